-- Schema 9: what a station says of an attempt beside its recording (schemas/wire/station.proto, AttemptFacts).

-- JSON object, one member for each fact that the server knew when it was told; '{}': nothing was said, as before this
-- schema. Said anew each time the attempt is opened; the last counts.
ALTER TABLE attempts ADD COLUMN facts TEXT NOT NULL DEFAULT '{}';
