import { useEffect, useState } from "preact/hooks";
import { ErrorNotice, Loading } from "./basics";

// A part of the page that is loaded when somebody comes to it.
export function usePart<Part>(load: () => Promise<Part>): Part | "loading" | "failed" {
  const [loaded, setLoaded] = useState<{ readonly part: Part } | "loading" | "failed">("loading");
  useEffect(() => { load().then((part) => setLoaded({ part }), () => setLoaded("failed")); }, []);
  return typeof loaded === "object" ? loaded.part : loaded;
}

export function PartState({ state }: { readonly state: "loading" | "failed" }) {
  if (state === "loading") return <Loading what="the page" />;
  return <ErrorNotice title="This part of the page could not be loaded" message="Check that this computer is connected, then load the page again." onRetry={() => window.location.reload()} />;
}
