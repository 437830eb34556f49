-- Schema 13: surface timelines of attempts (schemas/surface_timeline.md), made after the score.

-- One that is to be made, or was. Goes with the recording.
CREATE TABLE timelines (
  tenant  INTEGER NOT NULL,
  attempt BLOB NOT NULL,
  content BLOB CHECK (length(content) = 32),  -- NULL: not made
  tries   INTEGER NOT NULL DEFAULT 0,         -- begun, of those that did not end with it
  problem TEXT NOT NULL DEFAULT '',           -- why the last try failed
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX timelines_to_make ON timelines (tenant, attempt) WHERE content IS NULL;
INSERT INTO timelines (tenant, attempt) SELECT tenant, id FROM attempts WHERE state = 5 AND trace_blob IS NOT NULL;

-- What a timeline begins with: a volume before it is cut, as the page reads it. Nobody's.
CREATE TABLE start_teeth (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  volume  BLOB NOT NULL CHECK (length(volume) = 32),
  content BLOB NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, volume)
) STRICT, WITHOUT ROWID;
CREATE INDEX start_teeth_by_content ON start_teeth (tenant, content);
