# SPDX-License-Identifier: Apache-2.0
"""Makes a wheel (PEP 427) of the installed package: make_wheel.py <folder of thenar> <folder for the wheel>.

The shared libraries that Debian has and others may not lie in thenar/libs, where the module looks first.
"""
import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile

#: What every system has.
SYSTEM = re.compile(r"^(linux-vdso|ld-linux|libc|libm|libdl|librt|libpthread|libgcc_s|libstdc\+\+)[.\-]")


def libraries_of(module):
    """The libraries that the module needs, as the loader finds them: name to file."""
    said = subprocess.run(["ldd", module], capture_output=True, text=True, check=True).stdout
    found = re.findall(r"^\s*(\S+) => (\S+)", said, re.MULTILINE)
    missing = [name for name, file in found if file == "not"]
    if missing:
        sys.exit(f"make_wheel: {', '.join(missing)} is missing")
    return {name: file for name, file in found if not SYSTEM.match(name)}


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def main(package, out):
    module = next(package.glob("_core.*.so"))
    libs = package / "libs"
    libs.mkdir(exist_ok=True)
    for name, file in libraries_of(module).items():
        shutil.copy(file, libs / name)
    version = re.search(r'^project\(thenar VERSION (\S+)', (pathlib.Path(__file__).parents[1] / "CMakeLists.txt").read_text(),
                        re.MULTILINE).group(1)
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    glibc = "_".join(__import__("platform").libc_ver()[1].split(".")[:2])
    tag = f"{python}-{python}-manylinux_{glibc}_{sysconfig.get_platform().rsplit('-', 1)[1]}"
    info = f"thenar-{version}.dist-info"
    files = {f"thenar/{file.relative_to(package)}": file.read_bytes()
             for file in sorted(package.rglob("*")) if file.is_file() and "__pycache__" not in file.parts}
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: thenar\nVersion: {version}\nSummary: Real-time simulation of human grasping\n"
        f"Requires-Python: =={sys.version_info.major}.{sys.version_info.minor}.*\nRequires-Dist: numpy\n").encode()
    files[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: thenar\nRoot-Is-Purelib: false\nTag: {tag}\n").encode()
    record = "".join(record_line(name, data) for name, data in files.items()) + f"{info}/RECORD,,\n"
    files[f"{info}/RECORD"] = record.encode()
    out.mkdir(parents=True, exist_ok=True)
    wheel = out / f"thenar-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name)  # of no time: the same files give the same bytes
            entry.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    print(wheel)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
