-- Schema 2: recordings are kept under a key of their person (schemas/personal_data.md), people can be
-- erased, and rules say how long things are kept.

-- Who was erased, as the SHA-256 of the person's id: what is restored from an older backup is erased
-- again. The same list stands in the key ring; the longer of the two counts.
CREATE TABLE erasures (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  person_hash BLOB NOT NULL CHECK (length(person_hash) = 32),
  erased_ms   INTEGER NOT NULL,
  PRIMARY KEY (tenant, person_hash)
) STRICT, WITHOUT ROWID;

-- How long things are kept, in days; no row: for good.
CREATE TABLE retention_rules (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  what   TEXT NOT NULL CHECK (what IN ('unfinished', 'recordings', 'attempts')),
  days   INTEGER NOT NULL CHECK (days BETWEEN 1 AND 36500),
  PRIMARY KEY (tenant, what)
) STRICT, WITHOUT ROWID;

-- When a rule removed the recording and left the score; 0: it is there.
ALTER TABLE attempts ADD COLUMN expired_ms INTEGER NOT NULL DEFAULT 0;

-- Erasure and retention look for what is compared with an attempt.
CREATE INDEX attempts_by_reference ON attempts (tenant, reference) WHERE reference IS NOT NULL;
