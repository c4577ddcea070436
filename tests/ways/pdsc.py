#!/usr/bin/env python3
"""What a CMSIS-Pack's description gives to the compiler for one variant.

    pdsc.py FILE.pdsc VARIANT HEADER

Prints the sources; writes to HEADER what is to be included before all else.
"""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def main():
    description, variant, header = sys.argv[1:]
    components = ElementTree.parse(description).findall("components/component")
    component, = (c for c in components if c.get("Cvariant") == variant)
    pathlib.Path(header).write_text(component.findtext("Pre_Include_Global_h", ""))
    for file in component.findall("files/file"):
        if file.get("category") == "sourceC":
            print(file.get("name"))


if __name__ == "__main__":
    main()
