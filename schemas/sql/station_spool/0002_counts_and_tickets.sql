-- What version 1 knew chunk by chunk, when the server said that it has it, becomes a count: it says so
-- in the order of seq. What is counted (chunks to bytes) is changed in one transaction with the chunks it
-- counts.
--   committed            the server has the chunks below this one durably
--   committed_unix_ms    when it last said so
--   resumed              how often it was taken up again after a crash
--   spooled_unix_ms      when a chunk became durable here; NULL: by version 1
ALTER TABLE attempts ADD COLUMN chunks INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN ticks INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN gap_ticks INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN bytes INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN committed INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN committed_unix_ms INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN resumed INTEGER NOT NULL DEFAULT 0;
UPDATE attempts SET
  (chunks, ticks, gap_ticks, bytes, committed_unix_ms) =
    (SELECT count(*), coalesce(sum(ticks), 0), coalesce(sum(gap_ticks), 0), coalesce(sum(length(bytes)), 0),
            coalesce(max(committed_unix_ms), 0)
     FROM chunks WHERE attempt = attempts.id),
  committed = coalesce((SELECT min(seq) FROM chunks WHERE attempt = attempts.id AND committed_unix_ms IS NULL),
                       (SELECT count(*) FROM chunks WHERE attempt = attempts.id));
ALTER TABLE chunks DROP COLUMN committed_unix_ms;
ALTER TABLE chunks ADD COLUMN spooled_unix_ms INTEGER;

-- Tickets taken in advance, each locked with its person's PIN: `locked` is the ticket
-- (schemas/trace_format.md) under a key made from PIN and salt (station/session/ticket_safe.h): nonce,
-- then ciphertext and tag. Gone when used and uploaded or revoked. One that is handed back, has expired
-- unused or had too many wrong PINs has an empty `locked` until the server has been told
-- (schemas/wire/README.md, "Returned tickets"). `person` is the name to show in the list, `exercise` the
-- exercise's name. `wrong_pins`: since the last right one, counted before it is tried; no PIN is tried
-- before `wait_unix_ms`.
CREATE TABLE tickets (
  attempt         BLOB PRIMARY KEY CHECK (length(attempt) = 16),
  person          TEXT NOT NULL,
  exercise        TEXT NOT NULL,
  title           TEXT NOT NULL,
  profile         TEXT NOT NULL,
  expires_unix_ms INTEGER NOT NULL,
  salt            BLOB NOT NULL CHECK (length(salt) = 16),
  locked          BLOB NOT NULL,
  wrong_pins      INTEGER NOT NULL DEFAULT 0,
  wait_unix_ms    INTEGER NOT NULL DEFAULT 0
) WITHOUT ROWID;
