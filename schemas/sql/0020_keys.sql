-- Schema 20: which object of a bucket is a person's key, and what all servers of a school have in common.

-- A row is there when its object is: added after the object, deleted after it, by an erasure that has put
-- the person among the erased before (server/storage/s3_keyring.h). Empty where the key ring is a folder.
CREATE TABLE person_keys (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  person     BLOB NOT NULL CHECK (length(person) = 16),
  generation INTEGER NOT NULL CHECK (generation > 0),   -- at random; the object is <uuid>-<generation>
  hash       BLOB NOT NULL CHECK (length(hash) = 32),   -- SHA-256 of the object
  made_ms    INTEGER NOT NULL,
  PRIMARY KEY (tenant, person)
) STRICT, WITHOUT ROWID;

-- SHA-256 of what a server is known by: a server that has another is refused. Written by the first; empty
-- where only one server can have its rows here.
CREATE TABLE server_identity (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  name        TEXT NOT NULL CHECK (name IN ('station_certificate', 'ticket_key', 'key_ring')),
  fingerprint BLOB NOT NULL CHECK (length(fingerprint) = 32),
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;
