-- Schema 21: what the servers of one school share while they run.

-- Failures to sign in, counted by all servers together (server/auth/throttle.h). `key` is a hash under a key of
-- the school's, since what is typed as a login may be a password. Unlogged: after a crash of PostgreSQL, and on a
-- standby that takes over, counting begins again.
CREATE UNLOGGED TABLE sign_in_counters (
  tenant      BIGINT NOT NULL REFERENCES tenants (tenant),
  key         BYTEA NOT NULL CHECK (length(key) = 32),
  failures    BIGINT NOT NULL CHECK (failures >= 0),
  first_tries BIGINT NOT NULL CHECK (first_tries >= 0),
  last_ms     BIGINT NOT NULL,
  next_try_ms BIGINT NOT NULL,
  until_ms    BIGINT NOT NULL,  -- forgotten then
  PRIMARY KEY (tenant, key)
);
CREATE INDEX sign_in_counters_by_end ON sign_in_counters (tenant, until_ms);

-- What only one server does at a time, until then or until it says that it is done
-- (server/storage/engine/lease.h).
CREATE TABLE leases (
  tenant   BIGINT NOT NULL REFERENCES tenants (tenant),
  name     TEXT COLLATE "C" NOT NULL CHECK (name IN ('upkeep')),
  lease    BYTEA NOT NULL CHECK (length(lease) = 16),  -- of this holding of it
  until_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name)
);

-- A row while an erasure may have left copies of what it deleted (server/storage/engine/rewrite.h).
CREATE TABLE rewrite_due (
  tenant   BIGINT NOT NULL PRIMARY KEY REFERENCES tenants (tenant),
  since_ms BIGINT NOT NULL,
  mark     BYTEA NOT NULL CHECK (length(mark) = 16)  -- of whoever erased last
);

-- Who makes it, and until when nobody else takes it.
ALTER TABLE timelines ADD COLUMN owner BYTEA CHECK (length(owner) = 16);
ALTER TABLE timelines ADD COLUMN lease_until_ms BIGINT NOT NULL DEFAULT 0;
