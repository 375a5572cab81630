#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Create .venv with ROS 2 Jazzy from PyPI wheels and build the workspace into it.

Run by ``make setup`` with a Python 3.11 to 3.13 that is to carry the environment. Each step leaves
a stamp when it is complete, inside the environment it belongs to: a step whose inputs did not
change is skipped, one that was interrupted is done again. Two runs at once take turns.
"""

import contextlib
import fcntl
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from steps import report, run

TOOLS = Path(__file__).resolve().parent
ROOT = TOOLS.parent
VENV = ROOT / ".venv"
WORK = ROOT / ".ros"
STAMPS = VENV / ".built"
LOCK = TOOLS / "requirements.txt"
STRIP = TOOLS / "strip_leaked_paths.cmake"
PYTHONS = ((3, 11), (3, 13))
CONTENT_HASHED = ("package.xml", "setup.py", "setup.cfg", "CMakeLists.txt", "msg", "resource")
# Installed as links: an edit needs no build, a new file does.
NAMES_MATTER = ("launch", "config", "layouts")


def check_machine() -> None:
    """Say what is missing before anything is downloaded."""
    problems = []
    if not PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        problems.append(f"Python {platform.python_version()}: 3.11, 3.12 or 3.13 is needed")
    if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        problems.append(f"{platform.system()} {platform.machine()}: the wheels are Linux x86_64")
    if not Path(sysconfig.get_path("include"), "Python.h").exists():
        problems.append("Python.h is missing: apt install python3-dev")
    problems += [
        f"{tool} is missing: apt install build-essential"
        for tool in ("gcc", "g++", "make")
        if shutil.which(tool) is None
    ]
    try:
        import ensurepip  # noqa: F401
    except ImportError:
        problems.append("the venv module is missing: apt install python3-venv")
    if problems:
        sys.exit("setup_ros: " + "\nsetup_ros: ".join(problems))


def clean_environment() -> dict[str, str]:
    """Return the caller's environment without another ROS, venv or Python path in it."""
    drop = ("PYTHON", "AMENT_", "COLCON_", "CMAKE_", "ROS_", "_ROS_", "RMW_", "MAKEFLAGS")
    drop += ("MAKELEVEL", "MFLAGS", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
    env = {key: value for key, value in os.environ.items() if not key.startswith(drop)}
    env["PATH"] = f"{VENV / 'bin'}{os.pathsep}{env.get('PATH', os.defpath)}"
    env["COLCON_HOME"] = str(WORK / "colcon")
    if not os.access(Path.home(), os.W_OK):
        env["UV_CACHE_DIR"] = str(WORK / "uv")
        env["PIP_NO_CACHE_DIR"] = "1"
    return env


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Hold the set-up lock; a second run waits until the first is done."""
    WORK.mkdir(exist_ok=True)
    with (WORK / "lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            report("another set-up is running here, waiting for it")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def digest(paths: Iterable[Path], *, names_only: Iterable[Path] = (), extra: str = "") -> str:
    """Hash names and contents of files and folders, of some the names only."""
    total = hashlib.sha256(extra.encode())

    def files(tops: Iterable[Path]) -> Iterator[Path]:
        for top in tops:
            for file in sorted(top.rglob("*")) if top.is_dir() else [top]:
                if file.is_file() and "__pycache__" not in file.parts:
                    yield file

    for file in files(paths):
        total.update(f"{file.relative_to(ROOT)}\0".encode() + file.read_bytes())
    for file in files(names_only):
        total.update(f"{file.relative_to(ROOT)}\0".encode())
    return total.hexdigest()


def locked(name: str) -> str:
    """Return the entry of one distribution in the lock file, hashes included."""
    entry = re.search(rf"^{name}==(?:.*\\\n)*.*\n", LOCK.read_text("utf-8"), re.MULTILINE)
    if entry is None:
        sys.exit(f"setup_ros: {name} is not in {LOCK.name}; run make lock where it is")
    return entry.group()


def install(env: dict[str, str]) -> bool:
    """Make the virtual environment hold exactly the locked versions."""
    stamp = VENV / ".locked"
    wanted = digest([LOCK], extra=f"{sys.version}\0{VENV}")
    if stamp.exists() and stamp.read_text("utf-8") == wanted:
        return False
    shutil.rmtree(VENV, ignore_errors=True)
    making = f"making .venv with Python {platform.python_version()}"
    run(making, [sys.executable, "-m", "venv", VENV], env)
    python = str(VENV / "bin" / "python")
    pip = [python, "-m", "pip", "install", "-q", "--disable-pip-version-check", "--require-hashes"]
    first = WORK / "installer.txt"
    first.write_text(locked("uv"), "utf-8")
    run("installing uv", [*pip, "-r", first], env)
    # --system-certs: uv otherwise trusts only its own list, and fails behind a proxy with a
    # local authority.
    count = len(re.findall(r"^[\w-]+==", LOCK.read_text("utf-8"), re.MULTILINE))
    uv = [VENV / "bin" / "uv", "pip", "install", "-q", "--system-certs", "--python", python]
    packages = f"installing {count} packages, ROS 2 Jazzy among them"
    try:
        run(packages, [*uv, "--require-hashes", "-r", LOCK], env)
    except subprocess.CalledProcessError:
        run(f"uv failed; {packages}, by pip (slower)", [*pip, "-r", LOCK], env)
    stamp.write_text(wanted, "utf-8")
    return True


def forget(name: str, site: Path) -> None:
    """Remove what a build of a package left, so that nothing deleted in the source lives on.

    The build folder of a Python package only holds links to its source and stays: what runs at the
    same time imports through it.
    """
    (STAMPS / name).unlink(missing_ok=True)
    folders = [VENV / "share" / name, VENV / "lib" / name]
    if not (ROOT / name / "setup.py").exists():
        folders += [VENV / "include" / name, site / name, WORK / "build" / name]
        for library in (VENV / "lib").glob(f"lib{name}__*.so"):
            library.unlink()
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)


def outdated(packages: list[Path]) -> dict[str, str]:
    """Return the names of the packages to build, each with the stamp it gets when it is built."""
    wanted = {
        package.name: digest(
            [*(package / name for name in CONTENT_HASHED), STRIP],
            names_only=(package / name for name in NAMES_MATTER),
            extra=str(VENV),
        )
        for package in packages
    }

    def is_built(name: str) -> bool:
        stamp = STAMPS / name
        return (
            stamp.exists()
            and stamp.read_text("utf-8") == wanted[name]
            and ((VENV / "include" / name).is_dir() or (WORK / "build" / name).is_dir())
        )

    return {name: stamp for name, stamp in wanted.items() if not is_built(name)}


def colcon(
    env: dict[str, str], packages: list[Path], *options: str, venv: Path, base: Path
) -> None:
    """Build packages into ``venv``, with build and log folders in ``base``."""
    prefix = {"AMENT_PREFIX_PATH": str(venv), "CMAKE_PREFIX_PATH": str(venv)}
    prefix["PATH"] = f"{venv / 'bin'}{os.pathsep}{env['PATH']}"
    command = [venv / "bin" / "python", "-m", "colcon", "--log-base", base / "log", "build"]
    command += ["--base-paths", *packages, "--build-base", base / "build", "--install-base", venv]
    command += ["--merge-install", "--executor", "sequential", *options]
    run(f"building {' '.join(package.name for package in packages)}", command, env | prefix, base)


def build_messages(env: dict[str, str], names: list[str]) -> None:
    """Build message packages in a temporary folder.

    CMake's scripts fail on a path with a quote or a letter beyond ASCII in it, which the project's
    may have; there they see none of it.
    """
    with tempfile.TemporaryDirectory(prefix="pmwvc-") as folder:
        base = Path(folder)
        (base / "venv").symlink_to(VENV)
        sources = [shutil.copytree(ROOT / name, base / "source" / name) for name in names]
        strip = shutil.copy(STRIP, base)
        options = ["--cmake-args", f"-DCMAKE_PROJECT_INCLUDE={strip}", "-DBUILD_TESTING=OFF"]
        colcon(env, sources, *options, venv=base / "venv", base=base)


def build(env: dict[str, str]) -> list[str]:
    """Build the packages whose build inputs changed into the virtual environment."""
    site = next((VENV / "lib").glob("python3.*/site-packages"))
    STAMPS.mkdir(exist_ok=True)
    (WORK / "COLCON_IGNORE").touch()
    packages = sorted(path.parent for path in ROOT.glob("*/package.xml"))
    python = {package.name for package in packages if (package / "setup.py").exists()}
    changed = outdated(packages)
    removed = {path.name for path in STAMPS.iterdir()} - {path.name for path in packages}
    for name in sorted(removed | changed.keys()):
        forget(name, site)
    # colcon's develop install leaves only .egg-link files, which need a sourced shell; one .pth
    # file serves every process. Relative, because Python reads it in the encoding of the locale.
    lines = [os.path.relpath(WORK / "build" / name, site) + "\n" for name in sorted(python)]
    path_file = site / "workspace.pth"
    if not path_file.exists() or path_file.read_text("utf-8") != "".join(lines):
        path_file.write_text("".join(lines), "utf-8")
    if messages := sorted(changed.keys() - python):
        build_messages(env, messages)
    if scripts := sorted(changed.keys() & python):
        paths = [ROOT / name for name in scripts]
        colcon(env, paths, "--symlink-install", venv=VENV, base=WORK)
    for name, stamp in changed.items():
        (STAMPS / name).write_text(stamp, "utf-8")
    return [*messages, *scripts]


def main() -> None:
    """Check, install, build."""
    check_machine()
    env = clean_environment()
    try:
        with alone():
            fresh = install(env)
            built = build(env)
    except subprocess.CalledProcessError as error:
        command = " ".join(str(word) for word in error.cmd[:4])
        sys.exit(
            f"setup_ros: '{command} ...' failed with {error.returncode}; the reason stands above. "
            "Run make setup again once it is mended: it goes on where it stopped."
        )
    except KeyboardInterrupt:
        sys.exit("\nsetup_ros: interrupted; make setup goes on where it stopped")
    state = "installed" if fresh else "up to date"
    report(f"{state}; built: {' '.join(built) or 'nothing to do'}")


if __name__ == "__main__":
    main()
