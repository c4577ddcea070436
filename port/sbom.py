#!/usr/bin/env python3
"""Prints what rigcal consists of, as SPDX 2.3 (ISO/IEC 5962) in JSON.

    sbom.py SECONDS     the time of the release, in seconds since 1970

The library is its own files and nothing else: it links the C library's libm. Each file is
listed with its SHA-256, and with its SHA-1, because SPDX demands it.
"""
import datetime
import hashlib
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def version() -> str:
    text = (ROOT / "include/rigcal.h").read_text()
    return ".".join(re.findall(r"^#define RIGCAL_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)$", text, re.MULTILINE))


def licence() -> str:
    first = (ROOT / "LICENSE").read_text().split("\n", 1)[0].strip()
    known = {"MIT License": "MIT", "The MIT License": "MIT", "BSD 2-Clause License": "BSD-2-Clause",
             "BSD 3-Clause License": "BSD-3-Clause", "ISC License": "ISC"}
    if first not in known:
        sys.exit(f"sbom.py: LICENSE begins with {first!r}, which this script does not know")
    return known[first]


def main() -> None:
    if len(sys.argv) != 2 or not sys.argv[1].isdigit():
        sys.exit(__doc__)
    files, sums = [], []
    for path in sorted([*(ROOT / "include").glob("*.h"), *(ROOT / "src").glob("*.[ch]")]):
        content = path.read_bytes()
        name = path.relative_to(ROOT).as_posix()
        sha1 = hashlib.sha1(content).hexdigest()
        sums.append(sha1)
        files.append({
            "SPDXID": "SPDXRef-File-" + re.sub(r"[^A-Za-z0-9.-]", "-", name),
            "fileName": "./" + name,
            "checksums": [{"algorithm": "SHA1", "checksumValue": sha1},
                          {"algorithm": "SHA256", "checksumValue": hashlib.sha256(content).hexdigest()}],
            "licenseConcluded": licence(), "licenseInfoInFiles": ["NOASSERTION"],
            "copyrightText": "NOASSERTION"})
    code = hashlib.sha1("".join(sorted(sums)).encode()).hexdigest()
    created = datetime.datetime.fromtimestamp(int(sys.argv[1]), datetime.timezone.utc)
    json.dump({
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"rigcal-{version()}",
        "documentNamespace": f"urn:rigcal:{version()}:{code}",
        "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: port/sbom.py"]},
        "packages": [{
            "SPDXID": "SPDXRef-Package", "name": "rigcal", "versionInfo": version(),
            "downloadLocation": "NOASSERTION", "filesAnalyzed": True,
            "packageVerificationCode": {"packageVerificationCodeValue": code},
            "licenseConcluded": licence(), "licenseDeclared": licence(),
            "licenseInfoFromFiles": ["NOASSERTION"], "copyrightText": "NOASSERTION",
            "hasFiles": [file["SPDXID"] for file in files],
            "comment": "No dependency but the C library's libm."}],
        "files": files,
        "relationships": [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                           "relatedSpdxElement": "SPDXRef-Package"}],
    }, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
