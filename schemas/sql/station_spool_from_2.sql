-- A spool of version 2 becomes one of version 3.
ALTER TABLE attempts ADD COLUMN boot_id TEXT;
ALTER TABLE attempts ADD COLUMN boot_ms INTEGER;
