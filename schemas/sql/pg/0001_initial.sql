-- What PostgreSQL has in schema 1 beside the tables and indexes, which the server makes from schemas/sql/0001_initial.sql
-- (server/storage/engine/pg_migrations.cpp).

-- Each chunk updates its attempt's row. Half of each page stays free for the next version of a row, and a ticket and a
-- header are stored apart from 128 bytes on. So the next version fits beside the last and no index is touched (a
-- heap-only update).
ALTER TABLE attempts SET (fillfactor = 50, toast_tuple_target = 128);
ALTER TABLE sign_in_counters SET UNLOGGED;
ALTER TABLE running_servers SET UNLOGGED;
ALTER TABLE station_links SET UNLOGGED;

-- An index entry is too small for a document, so this one has its hash. Nobody gains from two documents with one MD5.
DROP INDEX calibrations_once;
CREATE UNIQUE INDEX calibrations_once ON calibrations (tenant, profile, md5(document));

-- What SQLite's RAISE(ABORT, ...) does.
CREATE FUNCTION enamel_refuse() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  RAISE EXCEPTION '%', TG_ARGV[0];
END $$;

CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
  FOR EACH ROW EXECUTE FUNCTION enamel_refuse('audit rows are never deleted');

CREATE FUNCTION enamel_audit_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NOT (
    NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
    NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND NEW.subject = OLD.subject AND
    NEW.content_hash = OLD.content_hash AND NEW.signature = OLD.signature AND NEW.chain = OLD.chain AND
    NEW.number = OLD.number AND NEW.previous = OLD.previous AND NEW.salt IS NULL AND
    NEW.state = CASE OLD.state WHEN '' THEN '' ELSE '{"erased":true}' END AND
    NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND (
      ((OLD.action LIKE 'person.%' OR OLD.action LIKE 'session.%' OR OLD.action = 'request.refused') AND
       NOT EXISTS (SELECT 1 FROM people p WHERE p.tenant = OLD.tenant AND
                   encode(p.id, 'hex') = replace(OLD.object, '-', ''))) OR
      (OLD.action <> 'attempt.ticket' AND
       EXISTS (SELECT 1 FROM audit t WHERE t.tenant = OLD.tenant AND t.object = OLD.object AND
               t.action = 'attempt.ticket' AND
               replace(t.after_json::json ->> 'person', '-', '') NOT IN
                 (SELECT encode(p.id, 'hex') FROM people p WHERE p.tenant = OLD.tenant)))))
  THEN
    RAISE EXCEPTION 'audit rows are never changed';
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
  FOR EACH ROW EXECUTE FUNCTION enamel_audit_change();

CREATE TRIGGER audit_heads_are_not_deleted BEFORE DELETE ON audit_heads
  FOR EACH ROW EXECUTE FUNCTION enamel_refuse('the audit trail only grows');
CREATE TRIGGER audit_heads_only_advance BEFORE UPDATE ON audit_heads
  FOR EACH ROW WHEN (NOT (NEW.tenant = OLD.tenant AND NEW.chain = OLD.chain AND NEW.number > OLD.number))
  EXECUTE FUNCTION enamel_refuse('the audit trail only grows');
