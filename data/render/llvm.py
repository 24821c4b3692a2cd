"""The library that compiles Mitsuba's kernels: looked for before Mitsuba is imported, missed in a sentence."""

from __future__ import annotations

from pathlib import Path

from stereo_lab.errors import StereoLabError

VARIABLE = "DRJIT_LIBLLVM_PATH"
PLACES = "/usr/lib"
OLDEST = 16  # LLVM 15 stops the whole program; Debian's libllvm19 works
INSTALL = f"Install it (Debian and Ubuntu: apt install libllvm19), or set {VARIABLE} to the library's file."
MISSING = f"Rendering needs the LLVM library, which was not found. {INSTALL}"


def point_to_llvm(environment, places=PLACES):
    """Tell Mitsuba, by the environment, which LLVM to take; one that the user has named stays.

    Parameters
    ----------
    environment : dict of str, such as ``os.environ``
    places : folder in whose folders Debian keeps libraries

    Raises
    ------
    StereoLabError
        If the user has named a file that is not there.
    """
    named = environment.get(VARIABLE)
    if named and not Path(named).is_file():
        raise StereoLabError(f"{VARIABLE} names {named}, and there is no such file. Correct it, or unset it.")
    found = sorted(Path(places).glob("*/libLLVM.so.19*"))
    if found and not named:
        environment[VARIABLE] = str(found[-1])


def start(drjit, mitsuba):
    """Choose the variant that traces many rays at once; Mitsuba's other one for the processor cannot.

    Parameters
    ----------
    drjit, mitsuba : the two modules

    Raises
    ------
    StereoLabError
        If LLVM cannot be loaded, or is too old.
    """
    if not drjit.has_backend(drjit.JitBackend.LLVM):
        raise StereoLabError(MISSING)
    version = drjit.detail.llvm_version()[0]
    if 0 < version < OLDEST:  # below zero: not known
        raise StereoLabError(f"Rendering needs LLVM {OLDEST} or newer, and {version} was found. {INSTALL}")
    try:
        mitsuba.set_variant("llvm_ad_rgb")
    except ImportError:
        raise StereoLabError(MISSING) from None
