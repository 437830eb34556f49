-- Schema 20: which object of a bucket is a person's key, and what all servers of a school have in common.

-- A row is there when its object is: added after the object, deleted after it, by an erasure that has put
-- the person among the erased before (server/storage/s3_keyring.h). Empty where the key ring is a folder.
CREATE TABLE person_keys (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  person     BYTEA NOT NULL CHECK (length(person) = 16),
  generation BIGINT NOT NULL CHECK (generation > 0),    -- at random; the object is <uuid>-<generation>
  hash       BYTEA NOT NULL CHECK (length(hash) = 32),  -- SHA-256 of the object
  made_ms    BIGINT NOT NULL,
  PRIMARY KEY (tenant, person)
);

-- SHA-256 of what a server is known by: a server that has another is refused. Written by the first; empty
-- where only one server can have its rows here.
CREATE TABLE server_identity (
  tenant      BIGINT NOT NULL REFERENCES tenants (tenant),
  name        TEXT COLLATE "C" NOT NULL CHECK (name IN ('station_certificate', 'ticket_key', 'key_ring')),
  fingerprint BYTEA NOT NULL CHECK (length(fingerprint) = 32),
  PRIMARY KEY (tenant, name)
);
