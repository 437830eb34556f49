import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { loadWords, say } from "../base/words";
import { ErrorNotice, Loading } from "./basics";

// A part of the page that is loaded when somebody comes to it, with its words: a component that
// shows what `show` makes of it.
export function part<Part>(name: Parameters<typeof loadWords>[0], load: () => Promise<Part>) {
  return function LoadedPart({ show }: { readonly show: (part: Part) => ComponentChildren }) {
    const [loaded, setLoaded] = useState<{ readonly part: Part } | "loading" | "failed">("loading");
    useEffect(() => {
      Promise.all([load(), loadWords(name)]).then(
        ([part]) => setLoaded({ part }),
        () => setLoaded("failed"),
      );
    }, []);
    if (loaded === "loading") return <Loading what={say("loading.page")} />;
    if (loaded === "failed")
      return (
        <ErrorNotice
          title={say("app.part_failed")}
          message={say("app.part_failed_hint")}
          onRetry={() => window.location.reload()}
        />
      );
    return <>{show(loaded.part)}</>;
  };
}
