export const kLanguages: readonly ["en", "de", "zh"];
export function placesOf(message: string, where: string): Record<string, "number" | "text">;
export function keysIn(source: string, keys: readonly string[]): string[];
