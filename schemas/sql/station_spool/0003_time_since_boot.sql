-- When an attempt's newest chunk became durable (without one: when it was begun), by a time that no clock
-- that is set changes: which start of the machine, and how long after it. NULL: by version 2.
ALTER TABLE attempts ADD COLUMN boot_id TEXT;
ALTER TABLE attempts ADD COLUMN boot_ms INTEGER;
