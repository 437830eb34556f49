import { useEffect, useState } from "preact/hooks";
import { loadWords, say } from "../base/words";
import { ErrorNotice, Loading } from "./basics";

// A part of the page that is loaded when somebody comes to it, with its words.
export function usePart<Part>(name: Parameters<typeof loadWords>[0], load: () => Promise<Part>): Part | "loading" | "failed" {
  const [loaded, setLoaded] = useState<{ readonly part: Part } | "loading" | "failed">("loading");
  useEffect(() => { Promise.all([load(), loadWords(name)]).then(([part]) => setLoaded({ part }), () => setLoaded("failed")); }, []);
  return typeof loaded === "object" ? loaded.part : loaded;
}

export function PartState({ state }: { readonly state: "loading" | "failed" }) {
  if (state === "loading") return <Loading what={say("loading.page")} />;
  return <ErrorNotice title={say("app.part_failed")} message={say("app.part_failed_hint")} onRetry={() => window.location.reload()} />;
}
