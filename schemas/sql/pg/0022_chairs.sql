-- Schema 22: how far remarks to chairs have come, and which stations are connected to which server.

-- Of a remark to the chair (to_chair = 1): what its station knows it by, which grows with each of an attempt's,
-- and how far it has come. NULL of what was said before this schema.
ALTER TABLE annotations ADD COLUMN remark_id BIGINT CHECK (remark_id > 0);
ALTER TABLE annotations ADD COLUMN remark_state TEXT COLLATE "C" CHECK (remark_state IN ('waiting', 'sent', 'shown'));
ALTER TABLE annotations ADD COLUMN shown_ms BIGINT NOT NULL DEFAULT 0;
CREATE INDEX annotations_to_chairs ON annotations (tenant, created_ms) WHERE remark_id IS NOT NULL;

-- Servers that are running, each under a name of its own for as long as it runs, and the stations that are connected to
-- them. One that has not been heard for a while is gone (server/storage/live_store.h). Unlogged: after a crash of
-- PostgreSQL, and on a standby that takes over, each server says it again.
CREATE UNLOGGED TABLE running_servers (
  tenant   BIGINT NOT NULL REFERENCES tenants (tenant),
  server   BYTEA NOT NULL CHECK (length(server) = 16),
  heard_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, server)
);
CREATE UNLOGGED TABLE station_links (
  tenant        BIGINT NOT NULL REFERENCES tenants (tenant),
  server        BYTEA NOT NULL CHECK (length(server) = 16),
  station       BYTEA NOT NULL CHECK (length(station) = 16),
  shows_remarks BIGINT NOT NULL CHECK (shows_remarks IN (0, 1)),
  PRIMARY KEY (tenant, server, station)
);
