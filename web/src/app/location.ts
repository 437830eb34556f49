import { signal } from "@preact/signals";
import { Places } from "../base/places";

const kPatienceMs = 10_000; // a list that takes longer to load is shown from its top

// Where the page is. Plain links work: a click on one inside the page moves without loading again.
export const location = signal(new URL(window.location.href));

const entryOf = (state: unknown): number => (state as { readonly entry?: number } | null)?.entry ?? 0;
const places = new Places(entryOf(history.state));
let stopReturning = (): void => {};

export function navigate(path: string, how: "push" | "replace" = "push"): void {
  stopReturning();
  if (how === "push") history.pushState({ entry: places.opened() }, "", path);
  else history.replaceState(history.state, "", path);
  location.value = new URL(window.location.href);
  if (how === "push") window.scrollTo(0, 0);
}

// Scrolls to `top` once the page is that high, unless somebody scrolls first.
function returnTo(top: number): void {
  stopReturning();
  const stopped = new AbortController();
  const grown = new ResizeObserver(() => {
    if (document.documentElement.scrollHeight - window.innerHeight < top) return;
    window.scrollTo(0, top);
    stopReturning();
  });
  const timer = setTimeout(() => stopReturning(), kPatienceMs);
  stopReturning = () => {
    stopped.abort();
    grown.disconnect();
    clearTimeout(timer);
  };
  for (const own of ["wheel", "pointerdown", "keydown", "touchstart"])
    window.addEventListener(own, () => stopReturning(), { signal: stopped.signal, passive: true });
  grown.observe(document.body);
}

export function followLinks(): void {
  history.scrollRestoration = "manual";
  window.addEventListener("scroll", () => places.seen(window.scrollY), { passive: true });
  window.addEventListener("popstate", ({ state }) => {
    const top = places.returned(entryOf(state));
    location.value = new URL(window.location.href);
    returnTo(top);
  });
  document.addEventListener("click", (event) => {
    if (
      event.defaultPrevented ||
      event.button !== 0 ||
      event.metaKey ||
      event.ctrlKey ||
      event.shiftKey ||
      event.altKey
    )
      return;
    const link = event.target instanceof Element ? event.target.closest("a") : null;
    if (link === null || link.target !== "" || link.hasAttribute("download") || link.origin !== window.location.origin)
      return;
    if (link.getAttribute("href")?.startsWith("#") === true) return;
    event.preventDefault();
    navigate(link.pathname + link.search);
  });
}
