"""verify_result_edits.py FOLDER: every edit of a signed result and its files is found by schemas/verify_result.py."""
import os
import subprocess
import sys

SCHEMAS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../schemas")
sys.path.insert(0, SCHEMAS)
import verify_result

folder = sys.argv[1]
path = os.path.join(folder, "result.bin")
with open(path, "rb") as file:
    good = file.read()
result, there = verify_result.check(folder, good)
assert len(there) == len(verify_result.FILES), there
assert result["points"] == 83.25
verify_result.check(folder, good, result["key"].hex())


def refused(data, begins, key=None):
    try:
        verify_result.check(folder, data, key)
    except ValueError as error:
        return str(error).startswith(begins)
    return False


assert refused(good, "result.bin: signed by another key", "00" * 32)
for bit in range(8 * len(good)):
    changed = bytearray(good)
    changed[bit // 8] ^= 1 << bit % 8
    assert refused(bytes(changed), "result.bin"), f"bit {bit} of result.bin"
for name in there:
    with open(os.path.join(folder, name), "rb") as file:
        content = file.read()

    def found(edited):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(edited)
        return refused(good, name)

    # Of a long recording, every bit of some bytes.
    step = max(1, len(content) // 80)
    for at in range(0, len(content), step):
        for bit in range(8):
            assert found(content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1:]), f"{name}, byte {at}, bit {bit}"
        assert found(content[:at]), f"{name}, cut off at {at}"
    assert found(content + b"\0"), f"{name}, longer"
    with open(os.path.join(folder, name), "wb") as file:
        file.write(content)

# As a person runs it.
script = os.path.join(SCHEMAS, "verify_result.py")
ok = subprocess.run([sys.executable, script, path], capture_output=True, text=True)
assert ok.returncode == 0 and "83.25 points" in ok.stdout, ok
with open(os.path.join(folder, "score.json"), "ab") as file:
    file.write(b" ")
bad = subprocess.run([sys.executable, script, path], capture_output=True, text=True)
assert bad.returncode == 1 and bad.stderr.startswith("REFUSED: score.json: changed"), bad
