-- Schema 5: an attempt's facts (schemas/wire/station.proto, AttemptFacts) stand in one column, so that a new fact
-- needs no new one.
--
--   facts                as the message, encoded; empty: nothing was said. `resumed` in it does not count: that is
--                        the column, which is counted up while the attempt is made
ALTER TABLE attempts ADD COLUMN facts BLOB NOT NULL DEFAULT x'';
