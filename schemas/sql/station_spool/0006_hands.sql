-- Schema 6: what may hold the tool in an attempt whose ticket was taken in advance, as the server said with it
-- (schemas/wire/station.proto, TicketIssued.hands): 1 devices on the school's list, 2 every haptic device, 3 a mouse
-- too, 4 anything.
ALTER TABLE tickets ADD COLUMN hands INTEGER NOT NULL DEFAULT 4;
