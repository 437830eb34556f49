import { signal } from "@preact/signals";

// Where the page is. Plain links work: a click on one inside the page moves without loading again.
export const location = signal(new URL(window.location.href));

export function navigate(path: string, how: "push" | "replace" = "push"): void {
  if (how === "push") history.pushState(null, "", path);
  else history.replaceState(null, "", path);
  location.value = new URL(window.location.href);
  if (how === "push") window.scrollTo(0, 0);
}

export function followLinks(): void {
  window.addEventListener("popstate", () => {
    location.value = new URL(window.location.href);
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
