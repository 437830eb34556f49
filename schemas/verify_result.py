#!/usr/bin/env python3
"""Checks a signed result and the files beside it, as result.md says. Needs python3-cryptography and nothing of Enamel.
verify_result.py result.bin [KEY]    KEY: the school's public key, 64 hexadecimal digits"""
import hashlib, os, struct, sys
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

NAMES = """magic version attempt scored header recording exercise rubric scene volume profile reference reference_recording
    reference_tooth score_document tooth deviation series judgement score_file tooth_file surface_file series_file points
    critical_fail metric_set core_version rubric_version flags hand key signature""".split()
LAYOUT = struct.Struct("<4sH16sq" + 7 * "32s" + "16s" + 11 * "32s" + "dBIIIIB32s64s")
FILES = {"score.json": "score_file", "tooth.envb": "tooth_file", "surface.ensf": "surface_file", "forces.json": "series_file",
         "exercise.json": "exercise", "rubric.json": "rubric", "scene.json": "scene", "start.envb": "volume",
         "profile.json": "profile", "recording.entrace": "recording"}

def last_chunk(data, result):
    """The last chunk's hash, after following the chain of the recording from its header."""
    at, last, chunks, ended = 8, None, 0, data[:8] != b"ENaf\x01\0\0\0"
    while at + 9 <= len(data) and not ended:
        kind, size = struct.unpack_from("<BI", data, at)
        content, at = data[at + 5:at + 5 + size], at + 9 + size
        if hashlib.sha256(data[at - 9 - size:at - 4]).digest()[:4] != data[at - 4:at]:
            return None
        if kind == 1 and last is None and hashlib.sha256(content).digest() == result["header"]:
            last = result["header"]
        elif kind == 2 and content[6:22] == result["attempt"] and content[50:82] == last:
            last, chunks = hashlib.sha256(content[:-64]).digest(), chunks + 1
        elif kind == 3 and content[6:26] == result["attempt"] + struct.pack("<I", chunks) and content[34:66] == last:
            ended = True
        else:
            return None
    return last if ended and at == len(data) else None

def check(folder, data, key=None):
    """The result, and the names of the files that are there, all as signed. ValueError: what is not."""
    if len(data) != LAYOUT.size or data[:6] != b"ENrd\x01\0":
        raise ValueError(f"result.bin: expected version 1, {LAYOUT.size} bytes that begin with ENrd")
    result = dict(zip(NAMES, LAYOUT.unpack(data)))
    try:
        Ed25519PublicKey.from_public_bytes(result["key"]).verify(result["signature"], b"enamel.result-document.v1" + data[:-64])
    except InvalidSignature:
        raise ValueError("result.bin: changed since it was signed")
    if key is not None and result["key"].hex() != key.lower():
        raise ValueError("result.bin: signed by another key, " + result["key"].hex())
    there = [name for name in FILES if os.path.exists(os.path.join(folder, name))]
    for name in there:
        content = open(os.path.join(folder, name), "rb").read()
        found = last_chunk(content, result) if name == "recording.entrace" else hashlib.sha256(content).digest()
        if found != result[FILES[name]]:
            raise ValueError(name + ": changed, or of another result")
    return result, there

if __name__ == "__main__":
    try:
        data = open(sys.argv[1], "rb").read()
        result, there = check(os.path.dirname(sys.argv[1]), data, *sys.argv[2:3])
    except (IndexError, OSError, ValueError) as error:
        sys.exit(__doc__ if isinstance(error, IndexError) else f"REFUSED: {error}")
    print(f"{result['points']:g} points for attempt {result['attempt'].hex()}, signed by {result['key'].hex()}")
    print("fingerprint:", hashlib.sha256(data).hexdigest(), "\nas signed:", ", ".join(there), "\nnot there:", ", ".join(name for name in FILES if name not in there))
