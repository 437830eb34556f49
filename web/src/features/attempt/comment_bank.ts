// Remarks that an instructor uses again and again, kept in the browser for each person.

type Storage = Pick<globalThis.Storage, "getItem" | "setItem">;

const kMost = 40;
const kMaxText = 4000;

export function commentsOf(person: string, storage: Storage = localStorage): readonly string[] {
  try {
    const found: unknown = JSON.parse(storage.getItem(keyOf(person)) ?? "[]");
    return Array.isArray(found)
      ? found
          .filter((text): text is string => typeof text === "string" && text !== "" && text.length <= kMaxText)
          .slice(0, kMost)
      : [];
  } catch {
    return [];
  }
}

// The newest first; what is there already moves to the front, and the oldest of too many goes.
export function keepComment(person: string, text: string, storage: Storage = localStorage): readonly string[] {
  const kept = [text.trim(), ...commentsOf(person, storage).filter((each) => each !== text.trim())]
    .filter((each) => each !== "")
    .slice(0, kMost);
  return write(person, kept, storage);
}

export function dropComment(person: string, text: string, storage: Storage = localStorage): readonly string[] {
  return write(
    person,
    commentsOf(person, storage).filter((each) => each !== text),
    storage,
  );
}

function write(person: string, texts: readonly string[], storage: Storage): readonly string[] {
  try {
    storage.setItem(keyOf(person), JSON.stringify(texts));
  } catch {
    // Kept for this page alone where the browser keeps nothing.
  }
  return texts;
}

function keyOf(person: string): string {
  return `enamel.comments.${person}`;
}
