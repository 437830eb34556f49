-- Schema 15: the signed rows of the audit trail are a chain (schemas/audit.md), and a scoring run can be taken back.

-- Which chain: a server's. NULL: from before this schema.
ALTER TABLE audit ADD COLUMN chain BLOB CHECK (length(chain) = 16);
-- Its place there, from 1.
ALTER TABLE audit ADD COLUMN number INTEGER CHECK (number > 0);
-- The hash of the row before it in its chain.
ALTER TABLE audit ADD COLUMN previous BLOB CHECK (length(previous) = 32);
CREATE UNIQUE INDEX audit_by_number ON audit (tenant, chain, number) WHERE chain IS NOT NULL;

-- Where each chain ends, signed.
CREATE TABLE audit_heads (
  tenant    INTEGER NOT NULL,
  chain     BLOB NOT NULL CHECK (length(chain) = 16),
  number    INTEGER NOT NULL CHECK (number > 0),      -- of its last row
  last_id   BLOB NOT NULL CHECK (length(last_id) = 16),
  hash      BLOB NOT NULL CHECK (length(hash) = 32),
  signature BLOB NOT NULL CHECK (length(signature) = 64),
  PRIMARY KEY (tenant, chain)
) STRICT, WITHOUT ROWID;
CREATE TRIGGER audit_heads_only_advance BEFORE UPDATE ON audit_heads
WHEN NOT (NEW.tenant = OLD.tenant AND NEW.chain = OLD.chain AND NEW.number > OLD.number)
BEGIN
  SELECT RAISE(ABORT, 'the audit trail only grows');
END;
CREATE TRIGGER audit_heads_are_not_deleted BEFORE DELETE ON audit_heads
BEGIN
  SELECT RAISE(ABORT, 'the audit trail only grows');
END;

-- As schema 12, and a row stays in its place.
CREATE TRIGGER audit_stays_in_place BEFORE UPDATE ON audit
WHEN NOT (NEW.chain IS OLD.chain AND NEW.number IS OLD.number AND NEW.previous IS OLD.previous)
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never changed');
END;

-- What a run left beside its score; NULL: no longer kept. Of the newest run as in attempts, so that the one before can
-- be made the newest again.
ALTER TABLE attempt_results ADD COLUMN final_volume BLOB CHECK (length(final_volume) = 32);
ALTER TABLE attempt_results ADD COLUMN surface BLOB CHECK (length(surface) = 32);
ALTER TABLE attempt_results ADD COLUMN series BLOB CHECK (length(series) = 32);
UPDATE attempt_results SET
  final_volume = (SELECT a.final_volume FROM attempts a WHERE a.tenant = attempt_results.tenant AND a.id = attempt_results.attempt),
  surface = (SELECT a.surface FROM attempts a WHERE a.tenant = attempt_results.tenant AND a.id = attempt_results.attempt),
  series = (SELECT a.series FROM attempts a WHERE a.tenant = attempt_results.tenant AND a.id = attempt_results.attempt)
WHERE run = (SELECT max(n.run) FROM attempt_results n WHERE n.tenant = attempt_results.tenant AND n.attempt = attempt_results.attempt);
