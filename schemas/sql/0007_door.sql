-- Schema 7: a password for one use is good for signing in once, and for some days; a session says from where and
-- with what it was begun, and erasing a person overwrites the addresses in the audit trail too.

-- When it was set; 0: before this schema, which is told for those that were for one use.
ALTER TABLE people ADD COLUMN password_ms INTEGER NOT NULL DEFAULT 0;
-- 1: one for one use that was signed in with.
ALTER TABLE people ADD COLUMN password_used INTEGER NOT NULL DEFAULT 0 CHECK (password_used IN (0, 1));
-- The days of those that wait to be used begin now: nobody was told that there are any.
UPDATE people SET password_ms = CAST(strftime('%s', 'now') AS INTEGER) * 1000 WHERE must_change_password = 1;

-- Of the peer: IPv4, or the /64 of an IPv6 address; '' of a session before this schema.
ALTER TABLE sessions ADD COLUMN address TEXT NOT NULL DEFAULT '';
-- "Firefox on Linux", or the station's name; '' where nothing is known.
ALTER TABLE sessions ADD COLUMN device TEXT NOT NULL DEFAULT '';

-- As schema 5, and what a person did at the door: those rows hold addresses.
DROP TRIGGER audit_is_not_changed;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
WHEN NOT (
  NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
  NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND
  NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND (
    ((OLD.action LIKE 'person.%' OR OLD.action LIKE 'session.%' OR OLD.action = 'request.refused') AND
     NOT EXISTS (SELECT 1 FROM people p WHERE p.tenant = OLD.tenant AND
                 lower(hex(p.id)) = replace(OLD.object, '-', ''))) OR
    (OLD.action <> 'attempt.ticket' AND
     EXISTS (SELECT 1 FROM audit t WHERE t.tenant = OLD.tenant AND t.object = OLD.object AND
             t.action = 'attempt.ticket' AND
             replace(json_extract(t.after_json, '$.person'), '-', '') NOT IN
               (SELECT lower(hex(p.id)) FROM people p WHERE p.tenant = OLD.tenant)))))
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never changed');
END;
