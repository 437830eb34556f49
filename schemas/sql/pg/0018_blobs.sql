-- Schema 18: where the bytes of a blob are, when they are in an S3 store (server/storage/s3_blobs.h).

-- A row is there when its object is: it is added after the object, and deleted before it. Whoever
-- deletes it sees in the same transaction that no row names the blob; who names one that may go with its
-- attempt changes the row in the same transaction. Empty where blobs are files.
CREATE TABLE blobs (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  hash       BYTEA NOT NULL CHECK (length(hash) = 32),  -- SHA-256 of the bytes: the blob's name
  generation BIGINT NOT NULL CHECK (generation > 0),    -- at random; the object is <hash>-<generation>
  put_ms     BIGINT NOT NULL,                           -- the last time that somebody put or named it
  PRIMARY KEY (tenant, hash)
);
