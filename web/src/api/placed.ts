import type { ApiError } from "./http";

// What the server says of a place in a document, for people.

// Its sentence without the place it begins with, and with numbers as people write them: 1000 and
// not 1E3.
export function plainMessage({ field, message }: Pick<ApiError, "field" | "message">): string {
  const own = field !== "" && message.startsWith(`${field}: `) ? message.slice(field.length + 2) : message;
  return own.replaceAll(/(?<![\w.])-?\d+(?:\.\d+)?E[+-]?\d+(?![\w.])/g, (number) => String(Number(number)));
}

// The message after its place, which appears once: the server's name for it, as a file has it, or the title that people
// know.
export function placedMessage(error: Pick<ApiError, "field" | "message">, place = error.field): string {
  return place === "" ? plainMessage(error) : `${place}: ${plainMessage(error)}`;
}
