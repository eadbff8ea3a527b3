"""Builds the package for pip with the standard library alone, so that it installs in a plain virtual environment without a
network: setuptools would need wheel there, which is not in it. PEP 517 says what pip calls, PEP 427 what a wheel is.
"""

import base64
import gzip
import hashlib
import io
import pathlib
import re
import tarfile
import zipfile

try:
    import tomllib
except ImportError:  # before Python 3.11; pip, which is what runs this, brings one
    from pip._vendor import tomli as tomllib

HERE = pathlib.Path(__file__).resolve().parent
WHEEL = "Wheel-Version: 1.0\nGenerator: photond\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
OF_THE_SOURCE = ["pyproject.toml", "README.md", "wheel_builder.py"]
DATE = (1980, 1, 1, 0, 0, 0)  # the same bytes for the same source


def _project():
    return tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def _version():
    return re.search(r'__version__ = "([^"]+)"', (HERE / "photond/_version.py").read_text(encoding="utf-8"))[1]


def _metadata():
    project = _project()
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {_version()}",
             f"Summary: {project['description']}", f"License: {project['license']['text']}",
             f"Requires-Python: {project['requires-python']}",
             *(f"Classifier: {classifier}" for classifier in project["classifiers"]),
             *(f"Requires-Dist: {needed}" for needed in project["dependencies"])]
    for extra, packages in project["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}", *(f'Requires-Dist: {package} ; extra == "{extra}"' for package in packages)]
    lines += ["Description-Content-Type: text/markdown", "", (HERE / project["readme"]).read_text(encoding="utf-8")]
    return "\n".join(lines)


def _modules():
    """Name in the wheel -> its bytes."""
    return {f"photond/{file.name}": file.read_bytes() for file in sorted((HERE / "photond").iterdir())
            if file.suffix == ".py" or file.name == "py.typed"}


def _write_wheel(folder, files):
    about = f"photond-{_version()}.dist-info"
    files = {**files, f"{about}/METADATA": _metadata().encode(), f"{about}/WHEEL": WHEEL.encode()}
    record = "".join(f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n"
                     for name, data in files.items())
    files[f"{about}/RECORD"] = f"{record}{about}/RECORD,,\n".encode()
    wheel = f"photond-{_version()}-py3-none-any.whl"
    with zipfile.ZipFile(pathlib.Path(folder) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, data)
    return wheel


def build_wheel(folder, settings=None, metadata_folder=None):
    return _write_wheel(folder, _modules())


def build_editable(folder, settings=None, metadata_folder=None):
    """The package as it lies here: `pip install -e`."""
    return _write_wheel(folder, {"photond.pth": f"{HERE}\n".encode()})


def build_sdist(folder, settings=None):
    stem = f"photond-{_version()}"
    files = {**{name: (HERE / name).read_bytes() for name in OF_THE_SOURCE}, **_modules(), "PKG-INFO": _metadata().encode()}
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, data in files.items():
            entry = tarfile.TarInfo(f"{stem}/{name}")
            entry.size, entry.mode = len(data), 0o644
            archive.addfile(entry, io.BytesIO(data))
    (pathlib.Path(folder) / f"{stem}.tar.gz").write_bytes(gzip.compress(packed.getvalue(), mtime=0))
    return f"{stem}.tar.gz"
