"""Films' files (renderer/film/film_file.h) as versions of before wrote them."""

import hashlib
import struct

NEWEST = 7
HEADER_BYTES = 80
DIGEST_BYTES = 32


def version_of(film):
    return struct.unpack_from("<I", film, 8)[0]


def passes_of(film):
    """What its header says."""
    return struct.unpack_from("<I", film, 24)[0]


def as_version(film, version):
    """The bytes of a film of the newest version, without a method's state, as version 6, 5 (without means of passes) or
    4 (nor origin) has them."""
    assert version_of(film) == NEWEST and version in (4, 5, 6)
    places, at = [], HEADER_BYTES
    for _ in range(8):
        length = 8 + struct.unpack_from("<Q", film, at)[0] + DIGEST_BYTES
        places.append((at, at + length))
        at += length
    header = film[:8] + struct.pack("<I", version) + film[12:48]
    header += hashlib.sha256(header).hexdigest()[:DIGEST_BYTES].encode()
    return header + film[HEADER_BYTES:places[version][1]] + film[at:]
