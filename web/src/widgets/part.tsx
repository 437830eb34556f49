import type { ComponentChildren } from "preact";
import { useLayoutEffect, useState } from "preact/hooks";
import { keepTrying } from "../base/keep_trying";
import { loadWords, say } from "../base/words";
import { ErrorNotice, Loading } from "./basics";

// The browser would find the files that a part's script needs when that is there. The build names them in the page
// (scripts/build.mjs).
function loadWith(name: string): void {
  const files = document.querySelector<HTMLMetaElement>(`meta[name="part-${name}"]`)?.content.split(" ") ?? [];
  for (const href of files)
    document.head.append(Object.assign(document.createElement("link"), { rel: "modulepreload", href }));
}

interface Props<Part> {
  readonly show: (part: Part) => ComponentChildren;
}

// A part of the page that is loaded when somebody comes to it, with its words: a component that
// shows what `show` makes of it. `begin` loads its script, for somebody who comes there soon.
export function part<Part>(name: Parameters<typeof loadWords>[0], load: () => Promise<Part>) {
  let script: Promise<Part> | undefined;
  let there: { readonly part: Part } | undefined; // with its words
  const begin = () => {
    if (script === undefined) loadWith(name);
    script ??= load();
    script.catch(() => {
      script = undefined;
    });
    return script;
  };
  function LoadedPart({ show }: Props<Part>) {
    const [loaded, setLoaded] = useState<{ readonly part: Part } | "loading" | "failed">(there ?? "loading");
    useLayoutEffect(() => {
      const shown = new AbortController();
      // Another language may be spoken than when it was loaded.
      const both = () => Promise.all([begin(), loadWords(name)]);
      void keepTrying(both, shown.signal, () => setLoaded("failed")).then(([part]) => {
        there ??= { part };
        setLoaded(there);
      });
      return () => shown.abort();
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
  }
  return Object.assign(LoadedPart, { begin });
}
