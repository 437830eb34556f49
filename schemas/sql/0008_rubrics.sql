-- Schema 8: the rubric of an exercise that is published can be corrected, and many attempts be scored again at once.

-- Corrections; without one the rubric in the exercise's document counts. The newest counts.
CREATE TABLE rubrics (
  tenant       INTEGER NOT NULL,
  exercise     BLOB NOT NULL,                             -- this version of it
  version      INTEGER NOT NULL CHECK (version > 1),      -- of the document, as scores name it
  content      BLOB NOT NULL CHECK (length(content) = 32),
  reason       TEXT NOT NULL,
  published_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) STRICT, WITHOUT ROWID;

-- Scoring runs that were asked for together. What became of each is in its job.
CREATE TABLE job_batches (
  tenant    INTEGER NOT NULL REFERENCES tenants (tenant),
  id        BLOB NOT NULL CHECK (length(id) = 16),
  title     TEXT NOT NULL,                                -- for people: "Year 2, class-1-molar"
  cohort    BLOB,                                         -- whose attempts they are
  cause     TEXT NOT NULL,                                -- of its jobs
  queued_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
ALTER TABLE jobs ADD COLUMN batch BLOB;                   -- none: a run by itself, which goes first
CREATE INDEX jobs_by_batch ON jobs (tenant, batch) WHERE batch IS NOT NULL;
