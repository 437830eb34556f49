-- Schema 14: motions of attempts, and which earlier one each lies nearest to (schemas/motion.md).

-- One that was measured with its attempt's newest score. Goes with the recording.
CREATE TABLE motions (
  tenant     INTEGER NOT NULL,
  attempt    BLOB NOT NULL,
  content    BLOB NOT NULL CHECK (length(content) = 32),
  nearest    BLOB CHECK (length(nearest) = 16),  -- an attempt; NULL: there was none before it, or it is erased
  others     INTEGER NOT NULL,                   -- it was compared with so many
  nearest_um INTEGER NOT NULL,
  median_um  INTEGER NOT NULL,
  size_um    INTEGER NOT NULL,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX motions_by_nearest ON motions (tenant, nearest) WHERE nearest IS NOT NULL;
