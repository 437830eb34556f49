-- Schema 16: the language in which somebody reads the page.

-- Of the page's languages (schemas/words.md); empty: the browser's.
ALTER TABLE people ADD COLUMN language TEXT COLLATE "C" NOT NULL DEFAULT '' CHECK (language IN ('', 'en', 'de', 'zh'));
