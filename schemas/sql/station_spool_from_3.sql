-- A spool of version 3 becomes one of version 4.
ALTER TABLE attempts ADD COLUMN refused_unix_ms INTEGER;
ALTER TABLE attempts ADD COLUMN waits_because TEXT;
ALTER TABLE attempts ADD COLUMN waits_since_unix_ms INTEGER;
ALTER TABLE attempts ADD COLUMN tried_unix_ms INTEGER;
CREATE TABLE loop_facts (
  attempt       BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  run           INTEGER NOT NULL,
  ended_unix_ms INTEGER NOT NULL,
  facts         TEXT NOT NULL,
  PRIMARY KEY (attempt, run)
);
