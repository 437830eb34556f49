#!/usr/bin/env python3
"""Plans of the store's statements in SQLite, in a school of 20 000 attempts: none may visit more than kMostRows rows of a
table, for each row of the tables before it, unless kExceptions says why. An exception that nothing needs fails.

The statements are those that server/storage has as text. The plans depend on the schema and on the statistics that it
brings, so no data is needed. Usage: plans.py SOURCE_FOLDER
"""

import glob
import os
import re
import sqlite3
import sys

kMostRows = 1000

kEverything = "reads everything: "
# File in server/storage, a part of the statement, why it visits more.
kExceptions = [
    ("attempts/attempt_rows.cpp", "FROM attempts a JOIN people p", "its caller adds an id, or what kSets and kLargeSets say"),
    ("attempts/job_rows.cpp", "FROM jobs j WHERE tenant = ?1", "its caller adds the state or the attempt"),
    ("attempts/job_rows.cpp", "CASE j.state WHEN 'running'", "newest first, up to a page's limit"),
    ("attempts/remark_rows.cpp", "FROM annotations n LEFT JOIN people", "its caller adds the attempt or the id"),
    ("audit/audit_rows.cpp", "FROM audit WHERE tenant = ?1", "newest first, up to a page's limit"),
    ("audit/audit_trail.cpp", "ORDER BY number DESC LIMIT 1", "the last row of an index"),
    ("audit/decisions.cpp", "", kEverything + "verify compares all rows with the trail"),
    ("backup/backup.cpp", "count(*)", kEverything + "a backup's manifest counts"),
    ("blobs/blob_rows.cpp", "FROM blobs WHERE tenant = ?1", "its caller adds the hash, or a page of the sweep"),
    ("blobs/named_blobs.cpp", "FROM attempts WHERE tenant = ?1", kEverything + "the sweep of blobs that no row names"),
    ("keys/key_rows.cpp", "FROM person_keys", kEverything + "a backup's keys"),
    ("move/move.cpp", "SELECT 1 FROM audit LIMIT 1", "one row"),
    ("people/cohort_rows.cpp", "FROM people p CROSS JOIN cohort_members m", "a school has few who teach"),
    ("people/device_rows.cpp", "LIMIT 1000", "the newest thousand attempts"),
    ("people/people_rows.cpp", "SELECT login, display_name",
     kEverything + "a name that looks Latin in another script, which is rare, is compared with all others"),
    ("people/people_rows.cpp", "role = 1 AND disabled = 0", "a school has few admins"),
    ("people/people_rows.cpp", "WHERE tenant = ?1 ORDER BY login", kEverything + "enamel-server admin list-people"),
    ("people/people_rows.cpp", "AND login > ?2",
     "by login, up to a page's limit; neither engine has an index for a part of a name"),
    ("people/roster_rows.cpp", "", kEverything + "a roster is compared with all people"),
    ("people/session_rows.cpp", "expires_ms < ?2", "those that have ended"),
    ("recordings/sealed_rows.cpp", "WITH RECURSIVE found", "one row for each step"),
    ("teaching/assignment_rows.cpp", "coalesce(c.name, '')", "an admin's list; other callers add a cohort or an id"),
    ("upkeep/erasures.cpp", "SELECT id FROM people", kEverything + "a start compares people with the key ring"),
    ("upkeep/mentions.cpp", "", kEverything + "an erasure looks for the name in what people typed"),
    ("verify/", "", kEverything + "verify"),
]
# Put together at run time from more than the file's own constants, or no statement of SQLite's: how many a file has.
kNotRead = {
    "attempts/attempt_rows.cpp": 2, "audit/decisions.cpp": 1, "blobs/named_blobs.cpp": 1,
    "engine/database_look.cpp": 1, "engine/pg_database.cpp": 1, "engine/query.cpp": 1,
    "people/session_rows.cpp": 1,
    "people/sign_in_rows.cpp": 2, "recordings/ingest_rows.cpp": 4, "recordings/sealed_rows.cpp": 1, "verify/verify_attempts.cpp": 1,
    "recordings/trace_rows.cpp": 1, "school/school_tables.cpp": 3, "teaching/assignment_rows.cpp": 1,
    "upkeep/erasures.cpp": 1, "upkeep/retention_rows.cpp": 1,
}
# What AttemptRows::Attempts puts together, from constants of its source: what a list is of, and its order. Of few attempts
# all, sorted; the newest without sorting.
kSets = {
    "a student's": ["a.person = %1"],
    "a student's under an assignment": ["a.person = %1", "kInAssignment"],
    "an assignment's": ["kInAssignment"], "a cohort's": ["kInCohort"], "an exercise's": ["kInExercise"],
    "an instructor's": ["kInTaught", "kTaughtBy", "kNotToBeMarkedBy"],
    "with an open appeal":
        ["a.id IN (SELECT o.attempt FROM appeals o WHERE o.tenant = ?1 AND o.state = 'open')"],
}
kSortedOrders = ["kNewestFirst", "kSortedByName", "kSortedByScore"]
# Of many: through the index of the order, without sorting, up to a page's limit.
kLargeSets = {
    "everybody's": ["kNotToBeMarkedBy"], "a large assignment's": ["kOfAssignment", "kTaughtBy"],
    "a large cohort's": ["kOfCohort", "kTaughtBy"], "an instructor's of many": ["kTaughtBy", "kNotToBeMarkedBy"],
    "a large exercise's": ["kOfExercise", "kTaughtBy"],
}
kWalkedOrders = {
    ("kNewestFirst", "kAfterId"): "SEARCH a USING PRIMARY KEY (tenant=?",
    ("kByName", "kAfterName"): "SEARCH p USING INDEX people_by_name (tenant=?",
    ("kByScore", "kAfterScore"): "SEARCH a USING INDEX attempts_by_score (tenant=?",
}

kLiteral = r'"((?:[^"\\]|\\.)*)"'


class Planner:
    def __init__(self, schema):
        self.db = sqlite3.connect(":memory:", isolation_level=None)
        self.db.executescript(schema)
        self.stats, self.sizes = {}, {}
        for table, index, stat in self.db.execute("SELECT tbl, idx, stat FROM sqlite_stat1"):
            rows = [int(each) for each in stat.split()]
            self.stats[index or table] = rows
            self.sizes[table] = max(self.sizes.get(table, 0), rows[0])

    def without_statistics(self):
        names = self.db.execute(
            "SELECT name FROM sqlite_schema WHERE type IN ('table', 'index') AND name NOT LIKE 'sqlite_stat%'"
        ).fetchall()
        # The key of a table without row ids is called as the table is; others have an index of their own for it.
        return [name for (name,) in names if name not in self.stats and name not in self.sizes]

    def table_of(self, alias, sql):
        if alias in self.sizes:
            return alias
        # An alias that stands for two tables: the larger one.
        named = [t for t in re.findall(r"(\w+) (?:AS )?" + alias + r"\b", sql) if t in self.sizes]
        return max(named, key=self.sizes.get, default=None)

    def steps(self, sql):
        """The plan, as SQLite words it (https://www.sqlite.org/eqp.html)."""
        places = max((int(n) for n in re.findall(r"\?(\d+)", sql)), default=0)
        return [step for *_, step in self.db.execute("EXPLAIN QUERY PLAN " + sql, [None] * places)]

    def finding(self, sql, walked=None):
        """Steps that visit too many rows, except `walked`, which gives rows in order until there are enough."""
        out = []
        for step in self.steps(sql):
            if walked and step.startswith(walked):
                continue
            loop = re.fullmatch(
                r"(SCAN|SEARCH|BLOOM FILTER ON) (\w+)(?: USING (AUTOMATIC )?.*?(?:INDEX (\w+)|PRIMARY KEY|INDEX))?"
                r"(?: ?\((.*)\))?", step)
            table = self.table_of(loop[2], sql) if loop else None
            if table is None:
                continue
            stat = self.stats.get(loop[4] or table)
            rows = self.sizes[table]
            if loop[1] == "SEARCH" and not loop[3] and stat:
                rows = stat[min((loop[5] or "").count("="), len(stat) - 1)]
            if rows > kMostRows:
                out.append(f"{step}: {rows} rows")
        return out


def constants(text):
    """Texts of macros and constants: name to text."""
    out = {}
    for name, value in re.findall(r"#define (ENAMEL_\w+)((?:[^\n\\]|\\\n|\\.)*)", text):
        out[name] = "".join(re.findall(kLiteral, value))
    for name, value in re.findall(r'constexpr char (k\w+)\[\] =\s*((?:"(?:[^"\\]|\\.)*"\s*|ENAMEL_\w+\s*)+);', text):
        parts = re.finditer(kLiteral + r"|(ENAMEL_\w+)", value)
        out[name] = "".join(out.get(part[2], "") if part[2] else part[1] for part in parts)
    return out


def placed(text):
    """With parameters for %1, %2 and %3, which stand for values until a statement is put together."""
    return re.sub(r"%(\d)", lambda found: f"?{int(found[1]) + 1}", text)


def attempt_lists(planner, known):
    """What is wrong with the plans of AttemptRows::Attempts."""
    def listed(conditions, order):
        parts = [known["kAttemptSelect"]] + [known.get(each, each) for each in conditions]
        return placed(" AND ".join(parts) + f" ORDER BY {known[order]} LIMIT 50")

    for what, conditions in kSets.items():
        for order in kSortedOrders:
            sql = listed(conditions, order)
            sorts = [each for each in planner.steps(sql) if order == "kNewestFirst" and each.endswith("ORDER BY")]
            yield from (f"attempts, {what}, {order}: {each}" for each in planner.finding(sql) + sorts)
    for what, conditions in kLargeSets.items():
        for (order, after), walked in kWalkedOrders.items():
            for page in [conditions, conditions + [after]]:
                sql = listed(page, order)
                steps = planner.steps(sql)
                problems = planner.finding(sql, walked) + [each for each in steps if each.endswith("ORDER BY")]
                if not steps[0].startswith(walked):
                    problems.append(f"begins with {steps[0]}, not with {walked}")
                yield from (f"attempts, {what}, {order}: {each}" for each in problems)


def statements(text, known):
    """The statements that a source has: literals, constants, macros and the numbers of enumerators, one after another."""
    for start in re.finditer(r'"(?:SELECT|INSERT|UPDATE|DELETE|WITH) ', text):
        at, sql = start.start(), ""
        while True:
            at += re.match(r"[\s+\\]*", text[at:]).end()
            if part := re.match(kLiteral, text[at:]):
                sql += part[1].replace('\\"', '"')
            elif part := re.match(r"(?:std::string\()?Sql\((?:[^()]|\([^()]*\))*\)\)?", text[at:]):
                sql += "1"
            elif (part := re.match(r"ENAMEL_\w+|k[A-Z]\w+", text[at:])) and part[0] in known:
                sql += known[part[0]]
            elif not (part := re.match(r"db\.RowLock\w*\(\)|\)(?=\s*\+)", text[at:])):
                break
            at += part.end()
        yield sql


def main(source):
    with open(os.path.join(source, "schemas/sql/0001_initial.sql"), encoding="utf-8") as file:
        planner = Planner(file.read())
    problems = [f"{name} has no statistics: add its line to sqlite_stat1 in schemas/sql/0001_initial.sql"
                for name in planner.without_statistics()]
    problems += [f"statistics of {name}: the tenant is one in all rows"
                 for name, rows in planner.stats.items() if len(rows) > 1 and rows[0] != rows[1]]
    root = os.path.join(source, "server/storage/")
    headers = {}
    for path in glob.glob(root + "**/*.h", recursive=True):
        with open(path, encoding="utf-8") as file:
            headers.update(constants(file.read()))
    needed, planned, of_attempts = set(), 0, {}
    for path in sorted(glob.glob(root + "**/*.cpp", recursive=True)):
        name = path[len(root):]
        with open(path, encoding="utf-8") as file:
            text = file.read()
        known = headers | constants(text)
        of_attempts = known if "kAttemptSelect" in known else of_attempts
        not_read = 0
        for sql in map(placed, statements(text, known)):
            try:
                finding = planner.finding(sql)
            except sqlite3.Error:
                not_read += 1
                continue
            planned += 1
            if not finding:
                continue
            reason = next((i for i, (where, part, _) in enumerate(kExceptions)
                           if name.startswith(where) and part in sql), None)
            if reason is None:
                problems.append(f"{name}: {sql}\n    " + "\n    ".join(finding))
            needed.add(reason)
        if not_read != kNotRead.get(name, 0):
            problems.append(f"{name}: expected {kNotRead.get(name, 0)} statements that cannot be read here, found {not_read}")
    problems += attempt_lists(planner, of_attempts)
    problems += [f"nothing needs the exception {kExceptions[i]}" for i in range(len(kExceptions)) if i not in needed]
    for problem in problems:
        print(problem)
    print(f"{planned} statements, {len(problems)} problems")
    return 1 if problems or planned < 300 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
