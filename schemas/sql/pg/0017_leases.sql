-- Schema 17: several servers take jobs from one queue.

-- Names one run of a job: a worker tells it with everything it writes, so that one whose lease ran out
-- changes nothing of the run that another makes now. None: the job waits, or was run by an earlier schema.
ALTER TABLE jobs ADD COLUMN lease BYTEA CHECK (length(lease) = 16);
-- The server whose lease it is; none: the only one there is.
ALTER TABLE jobs ADD COLUMN owner BYTEA CHECK (length(owner) = 16);

CREATE UNIQUE INDEX jobs_by_lease ON jobs (tenant, lease) WHERE lease IS NOT NULL;
-- One run of an attempt at a time.
CREATE UNIQUE INDEX jobs_running ON jobs (tenant, attempt) WHERE state = 'running';
