// Gives the person a file that was made in the page.
export function downloadFile(name: string, type: string, content: string | ArrayBuffer): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  URL.revokeObjectURL(url);
}

// A name that every file system takes.
export function fileName(...parts: readonly string[]): string {
  return parts
    .map((part) =>
      part
        .normalize("NFKD")
        .replace(/\p{M}/gu, "")
        .replace(/[^\w.-]+/g, "_")
        .replace(/^[_.]+|_+$/g, ""),
    )
    .filter((part) => part !== "")
    .join("_");
}
