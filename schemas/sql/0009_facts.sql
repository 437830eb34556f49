-- Schema 9: what a station says of an attempt beside its recording (schemas/wire/station.proto, AttemptFacts), and the
-- signed document of each scoring run.

-- JSON object, one member for each fact that the server knew when it was told; '{}': nothing was said, as before this
-- schema. Said anew each time the attempt is opened; the last counts.
ALTER TABLE attempts ADD COLUMN facts TEXT NOT NULL DEFAULT '{}';

-- What a scoring run found and what it was found from, signed (schemas/result.md); NULL: not signed.
ALTER TABLE attempt_results ADD COLUMN document BLOB;
