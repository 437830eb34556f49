-- Schema 19: which remarks were said to the chair while the attempt was made.

ALTER TABLE annotations ADD COLUMN to_chair BIGINT NOT NULL DEFAULT 0 CHECK (to_chair IN (0, 1));
