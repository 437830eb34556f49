# Writes folded_table.inc, what Folded (folded.h) makes of characters outside ASCII, from Python's
# copy of the Unicode Character Database:
#   python3 common/base/folded_table.py >common/base/folded_table.inc
import unicodedata

# Letters that have no decomposition and that people leave out when they type.
LETTERS = dict(zip("ØøŁłĐđÐðıĦħŦŧŊŋςƀɃƗɨƟɵ", "oollddddihhttnnσbbiioo")) | {
    "ß": "ss", "ẞ": "ss", "Æ": "ae", "æ": "ae", "Œ": "oe", "œ": "oe", "Þ": "th", "þ": "th"}
# Latin, Greek, Cyrillic, Armenian, Georgian, ligatures and full-width forms; marks of Hebrew and Arabic.
AREAS = [(0x80, 0x780), (0x10A0, 0x1100), (0x1AB0, 0x1B00), (0x1C80, 0x1CC0), (0x1DC0, 0x2000),
         (0x20D0, 0x2100), (0x2C00, 0x2E00), (0xA640, 0xA6A0), (0xA720, 0xA800), (0xFB00, 0xFB10),
         (0xFE20, 0xFE30), (0xFF00, 0xFFF0)]
VOWELS_AND_DOTS = (0, 7, 9)  # combining classes of what a word needs in Indic scripts


def folded(text):
    for _ in range(3):
        parts = [c for c in unicodedata.normalize("NFKD", text)
                 if unicodedata.combining(c) in VOWELS_AND_DOTS]
        text = "".join(LETTERS.get(c, c.lower()) for c in parts)
    return text


changed = {}
for first, end in AREAS:
    for code in range(first, end):
        after = folded(chr(code))
        if unicodedata.category(chr(code)) not in ("Cn", "Co") and after != chr(code):
            changed[code] = after


def last_of(code, step, follows):
    while code + step in changed and follows(code + step):
        code += step
    return code


def cells():
    done = -1
    for code, after in sorted(changed.items()):
        if code <= done:
            continue
        ends = {"kSame": last_of(code, 1, lambda c: changed[c] == after)}
        if len(after) == 1:
            by = ord(after) - code
            ends["kShift"] = last_of(code, 1, lambda c: changed[c] == chr(c + by))
            if by == 1:
                ends["kPairs"] = last_of(code, 2, lambda c: changed[c] == chr(c + 1) and c - 1 not in changed)
        how = max(ends, key=lambda each: (ends[each], each == "kSame"))
        done = ends[how]
        yield '{0x%x, 0x%x, %s, "%s"},' % (code, done, how, after.replace('"', '\\"').replace("\\", "\\\\"))


line = ""
for cell in cells():
    if len(line) + len(cell) > 98:
        print(line)
        line = ""
    line += (" " if line else "") + cell
print(line)
