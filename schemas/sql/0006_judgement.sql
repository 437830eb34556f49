-- Schema 6: what is said about an attempt has a revision, so that two people who judge at once see each other;
-- how fast a run replayed stands beside its score, not in it: the same recording has the same score, to the bit.

-- Counts scores that differ, releases, overrides, excuses and flags.
ALTER TABLE attempts ADD COLUMN revision INTEGER NOT NULL DEFAULT 1;

-- Recorded time / replay time; 0: of a run before this schema.
ALTER TABLE attempt_results ADD COLUMN replay_realtime_factor REAL NOT NULL DEFAULT 0;

-- Written when a write has failed, to see whether the next one succeeds.
CREATE TABLE write_probe (
  tenant INTEGER NOT NULL PRIMARY KEY,
  at_ms  INTEGER NOT NULL
) STRICT;
