"""Builds a wheel of the module with CMake, as `pip wheel .` asks for it (PEP 517).

--config-settings build-dir=FOLDER names a build folder of CMake to build in; default: build/wheel.
"""
import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
NAME = "taut"


def build_module(folder):
    """Compiles the module and returns its file."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "CMakeCache.txt").exists():
        configure = ["cmake", "-S", SOURCE, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"]
        configure += ["-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=24", "-DTAUT_PYTHON=ON"]
        subprocess.run([*map(str, configure), f"-DPython_EXECUTABLE={interpreter()}"], check=True)
    subprocess.run(["cmake", "--build", str(folder), "--target", "taut_python"], check=True)
    (module,) = (folder / "render/python").glob(f"{NAME}*{sysconfig.get_config_var('EXT_SUFFIX')}")
    return module


def interpreter():
    """Python itself, not that of a virtual environment: CMake looks for its headers beside it."""
    return os.path.realpath(sys.executable)


def version():
    found = re.search(r"project\(taut VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text())
    return found.group(1)


def tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Writes the wheel and returns its name."""
    folder = (config_settings or {}).get("build-dir", SOURCE / "build/wheel")
    module = build_module(pathlib.Path(folder))
    info = f"{NAME}-{version()}.dist-info"
    metadata = f"Metadata-Version: 2.1\nName: {NAME}\nVersion: {version()}\nRequires-Dist: numpy\n"
    metadata += "Summary: Simulates ropes, chains and cords, and renders them\nLicense: MIT\n"
    files = {
        module.name: module.read_bytes(),
        f"{NAME}-stubs/__init__.pyi": (SOURCE / "render/python/taut.pyi").read_bytes(),
        f"{info}/METADATA": metadata.encode(),
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: taut\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode(),
        f"{info}/LICENSE": (SOURCE / "LICENSE").read_bytes(),
    }
    record = "".join(record_line(name, data) for name, data in files.items()) + f"{info}/RECORD,,\n"
    files[f"{info}/RECORD"] = record.encode()
    name = f"{NAME}-{version()}-{tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path)  # without a date: the same files give the same bytes
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    return name
