"""The two commands of the README in a Debian 12 that has nothing but apt: what the package lists leave out is missing there.

Needs root, mmdebstrap and mounts of its own; where those are not to be had these tests fail. What a root takes over from
this machine is how packages are reached: name servers, and the certificates that this machine trusts.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
CERTIFICATES = pathlib.Path("/etc/ssl/certs/ca-certificates.crt")
MOST_SECONDS = 9 * 60  # from nothing to the first picture, on two quiet cores
ENTER = """
set -e
mount -t proc proc "$1/proc"
mount -t tmpfs tmpfs "$1/dev"
mkdir "$1/dev/shm"
mount -t tmpfs tmpfs "$1/dev/shm"
for device in null zero full random urandom tty; do touch "$1/dev/$device"; mount --bind "/dev/$device" "$1/dev/$device"; done
ln -s /proc/self/fd "$1/dev/fd"
exec chroot "$1" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
    NODE_EXTRA_CA_CERTS=/etc/certificates-of-the-host.crt /bin/bash -c "cd /photond && $2"
"""


class BareDebian:
    """A root with nothing in it but Debian's essential packages, apt, and a copy of the working tree in /photond."""

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="photond-bare-", dir=os.environ.get("PHOTOND_BARE_DIR")))
        self.root = self.folder / "root"
        subprocess.run(["mmdebstrap", "--quiet", "--variant=minbase", "bookworm", self.root], check=True)
        shutil.copy("/etc/resolv.conf", self.root / "etc/resolv.conf")
        if CERTIFICATES.exists():
            shutil.copy(CERTIFICATES, self.root / "etc/certificates-of-the-host.crt")
        tracked = subprocess.run(["git", "-C", SOURCE, "ls-files", "-co", "--exclude-standard", "-z"], check=True,
                                 capture_output=True).stdout.decode().split("\0")
        for name in filter(None, tracked):
            if (SOURCE / name).exists():
                (self.root / "photond" / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(SOURCE / name, self.root / "photond" / name)

    def run(self, command):
        """Its exit status, in process and mount namespaces of its own: what the command leaves running ends with it."""
        return subprocess.run(["unshare", "--mount", "--pid", "--fork", "--kill-child", "bash", "-c", ENTER, "enter", self.root,
                               command]).returncode

    def close(self):
        shutil.rmtree(self.folder)


class LongBareDebian(unittest.TestCase):
    def setUp(self):
        self.bare = BareDebian()
        self.addCleanup(self.bare.close)

    def test_the_quickstart_leads_to_a_picture(self):
        began = time.monotonic()
        self.assertEqual(self.bare.run("deploy/quickstart --picture"), 0)
        seconds = time.monotonic() - began
        picture = self.bare.root / "photond/build/quickstart/images/cornell-box.png"
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(picture.stat().st_size, 50_000)  # 512 x 512 of one colour take 2 KB
        print(f"\nfrom a bare root to the first picture: {seconds:.0f} s of wall time, packages included "
              f"(asked: {MOST_SECONDS} on two quiet cores)", file=sys.stderr)

    def test_the_tests_are_built_and_run(self):
        """One of each kind: GoogleTest, lavapipe under validation, a daemon, the Python client, a browser."""
        self.assertEqual(self.bare.run(
            r"tests/run -R '^(unit\.(Film|GpuDevice)\.|service\.(jobs|flip_map|openapi|python_client_package)_test|dashboard\.(logic|now))'"), 0)


if __name__ == "__main__":
    unittest.main()
