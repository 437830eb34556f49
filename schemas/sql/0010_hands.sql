-- Schema 10: what held the tool, and what may.

-- What may hold the tool in graded work and exams: 1 devices on the school's list, 2 every haptic device, 3 a mouse too,
-- 4 anything. Assignments from before this schema had no such term: what they were made for goes on.
ALTER TABLE assignments ADD COLUMN hands INTEGER NOT NULL DEFAULT 4;

-- The term it was begun under, as it was then.
ALTER TABLE attempts ADD COLUMN hands INTEGER NOT NULL DEFAULT 4;

-- What held it, of the recording's header: 0 not told, 1 haptic device, 2 pointer, 3 program; and the rest as the header
-- has it (schemas/trace_format.md, "Hand").
ALTER TABLE attempts ADD COLUMN hand_kind INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN hand_device TEXT NOT NULL DEFAULT '';
ALTER TABLE attempts ADD COLUMN hand_driver TEXT NOT NULL DEFAULT '';
ALTER TABLE attempts ADD COLUMN hand_unit TEXT NOT NULL DEFAULT '';

-- Haptic devices that graded work is done with, by unit ("hid:1209:0001:SERIAL"), or by model where a unit cannot be
-- told from another.
CREATE TABLE listed_devices (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  name     TEXT NOT NULL,
  title    TEXT NOT NULL,                                 -- for people: "chair 3"
  added_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;
