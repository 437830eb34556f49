import type { Fetch } from "./request_init";

// What a server answered, by address: kept in a file, so that the page can show it without a server (scripts/demo.mjs).

export type Answers = Readonly<Record<string, Answer>>;
type Answer = { readonly json: unknown } | { readonly base64: string };

// Answers as that server did. What nobody asked it then is not found.
export function fromAnswers(answers: Answers): Fetch {
  return async (path, { headers }) => {
    const answer = answers[path];
    if (answer === undefined) return new Response(JSON.stringify({ error: { code: "not_found" } }), { status: 404 });
    if ("json" in answer) return new Response(JSON.stringify(answer.json));
    const bytes = Uint8Array.from(atob(answer.base64), (letter) => letter.charCodeAt(0));
    const range = /^bytes=(\d+)-(\d+)$/.exec((headers as Record<string, string>)["Range"] ?? "");
    if (range === null) return new Response(bytes);
    return new Response(bytes.subarray(Number(range[1]), Number(range[2]) + 1), { status: 206 });
  };
}
