#!/usr/bin/env python3
"""Evaluates a Kconfig as menuconfig would and prints what it gives to CMake.

    kconfig.py KCONFIG [SYMBOL=VALUE...]
"""
import sys

import kconfiglib


def main():
    kconfig = kconfiglib.Kconfig(sys.argv[1], warn_to_stderr=False)
    for choice in sys.argv[2:]:
        name, value = choice.split("=")
        if not kconfig.syms[name].set_value(value):
            kconfig.warnings.append(f"{name} cannot be {value}")
    if kconfig.warnings:
        sys.exit("kconfig: " + "\n".join(kconfig.warnings))
    for symbol in kconfig.unique_defined_syms:
        if symbol.str_value != "n":
            print(f"-DCONFIG_{symbol.name}={symbol.str_value}")


if __name__ == "__main__":
    main()
