--   refused_unix_ms      since when the server will not have it
--   waits_because        why the last try to send it failed, where another may not; NULL: it went well,
--                        or there was none
--   waits_since_unix_ms  of the tries in a row that failed the first
--   tried_unix_ms        the last
ALTER TABLE attempts ADD COLUMN refused_unix_ms INTEGER;
ALTER TABLE attempts ADD COLUMN waits_because TEXT;
ALTER TABLE attempts ADD COLUMN waits_since_unix_ms INTEGER;
ALTER TABLE attempts ADD COLUMN tried_unix_ms INTEGER;

-- How the loop went that recorded an attempt (schemas/loop_facts.md): `run` 0 as it was begun, n after
-- it was resumed n times. A run that a crash ended has none.
CREATE TABLE loop_facts (
  attempt       BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  run           INTEGER NOT NULL,
  ended_unix_ms INTEGER NOT NULL,
  facts         TEXT NOT NULL,
  PRIMARY KEY (attempt, run)
);
