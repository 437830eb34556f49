-- Schema 15: the signed rows of the audit trail are a chain (schemas/audit.md).

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
