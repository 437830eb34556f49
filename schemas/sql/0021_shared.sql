-- Schema 21: what the servers of one school share while they run.

-- Failures to sign in, counted by all servers together (server/auth/throttle.h). Empty where only one server
-- can have its rows here: that one counts in memory. `key` is a hash under a key of the school's, since what is
-- typed as a login may be a password.
CREATE TABLE sign_in_counters (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  key         BLOB NOT NULL CHECK (length(key) = 32),
  failures    INTEGER NOT NULL CHECK (failures >= 0),
  first_tries INTEGER NOT NULL CHECK (first_tries >= 0),
  last_ms     INTEGER NOT NULL,
  next_try_ms INTEGER NOT NULL,
  until_ms    INTEGER NOT NULL,  -- forgotten then
  PRIMARY KEY (tenant, key)
) STRICT, WITHOUT ROWID;
CREATE INDEX sign_in_counters_by_end ON sign_in_counters (tenant, until_ms);

-- What only one server does at a time, until then or until it says that it is done
-- (server/storage/engine/lease.h). Empty where only one server can have its rows here.
CREATE TABLE leases (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  name     TEXT NOT NULL CHECK (name IN ('upkeep')),
  lease    BLOB NOT NULL CHECK (length(lease) = 16),  -- of this holding of it
  until_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

-- A row while an erasure may have left copies of what it deleted (server/storage/engine/rewrite.h). Where
-- only one server can have its rows here, a file in the data folder says so.
CREATE TABLE rewrite_due (
  tenant   INTEGER NOT NULL PRIMARY KEY REFERENCES tenants (tenant),
  since_ms INTEGER NOT NULL,
  mark     BLOB NOT NULL CHECK (length(mark) = 16)  -- of whoever erased last
) STRICT;

-- Who makes it, and until when nobody else takes it.
ALTER TABLE timelines ADD COLUMN owner BLOB CHECK (length(owner) = 16);
ALTER TABLE timelines ADD COLUMN lease_until_ms INTEGER NOT NULL DEFAULT 0;
