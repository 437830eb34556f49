-- Schema 5: erasing a person overwrites what the audit trail tells of that person's attempts too: remarks,
-- appeals and reasons are words about somebody (schemas/personal_data.md).

-- Who was given an attempt stands in its row `attempt.ticket`, which holds ids only, is never overwritten,
-- and says whose the attempt was when a retention rule has long removed it.
DROP TRIGGER audit_is_not_changed;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
WHEN NOT (
  NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
  NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND
  NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND (
    (OLD.action LIKE 'person.%' AND
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
