import { spokenLocale } from "./language";

// The browser's <input type="datetime-local"> speaks local time without a zone, to the minute.

export function toLocalInput(unixMs: number): string {
  if (!Number.isFinite(unixMs) || unixMs <= 0) return "";
  const date = new Date(unixMs);
  const two = (value: number) => String(value).padStart(2, "0");
  return `${String(date.getFullYear()).padStart(4, "0")}-${two(date.getMonth() + 1)}-${two(date.getDate())}T${two(date.getHours())}:${two(date.getMinutes())}`;
}

// Undefined for what is no time.
export function fromLocalInput(text: string): number | undefined {
  if (!/^\d{4}-\d{2}-\d{2}T\d{2}:\d{2}(:\d{2})?$/.test(text)) return undefined;
  const unixMs = new Date(text).getTime();
  return Number.isFinite(unixMs) ? unixMs : undefined;
}

// "in 3 days", "2 hours ago": the largest unit that fits, in the language of the page.
export function relativeTime(unixMs: number, nowMs: number): string {
  const format = new Intl.RelativeTimeFormat(spokenLocale(), { numeric: "auto" });
  const seconds = (unixMs - nowMs) / 1000;
  const units: ReadonlyArray<readonly [Intl.RelativeTimeFormatUnit, number]> = [
    ["day", 86_400],
    ["hour", 3600],
    ["minute", 60],
  ];
  for (const [unit, size] of units) {
    if (Math.abs(seconds) >= size) return format.format(Math.trunc(seconds / size), unit);
  }
  return format.format(Math.trunc(seconds), "second");
}
