-- The station's spool, version 1 (PRAGMA user_version = 1). Recordings are durable here before they
-- are sent, and stay until the server has had them for a week. WAL, synchronous = FULL.

-- One attempt. `header` is the recording's header as sent (schemas/trace_format.md). The seal's
-- columns are NULL until the attempt ended; `sealed_at_server` is set when the server confirmed it.
CREATE TABLE attempts (
  id               BLOB PRIMARY KEY CHECK (length(id) = 16),
  header           BLOB NOT NULL,
  header_sha256    BLOB NOT NULL CHECK (length(header_sha256) = 32),
  exercise         TEXT NOT NULL,          -- its name, for people
  profile          TEXT NOT NULL,
  created_unix_ms  INTEGER NOT NULL,
  seal_chunks      INTEGER,
  seal_ticks       INTEGER,
  seal_last_sha256 BLOB,
  seal_state_hash  INTEGER,                -- bit pattern of the unsigned hash
  sealed_at_server INTEGER NOT NULL DEFAULT 0,
  refused          TEXT                    -- why the server will not have it, in its words
) WITHOUT ROWID;

-- One chunk of an attempt, as sent. Idempotent by (attempt, seq, sha256).
CREATE TABLE chunks (
  attempt           BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  seq               INTEGER NOT NULL,
  sha256            BLOB NOT NULL CHECK (length(sha256) = 32),   -- of the unsigned part
  bytes             BLOB NOT NULL,
  ticks             INTEGER NOT NULL,
  gap_ticks         INTEGER NOT NULL,
  committed_unix_ms INTEGER,               -- when the server said it is durable there
  PRIMARY KEY (attempt, seq)
);
