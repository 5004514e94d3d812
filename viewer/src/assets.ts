// Files beside the page: on its server, or inside the page where that is one file (src/cli/serve/one_file.rs), as base64 in elements
// that browsers do not run.

/** Characters of base64 that are decoded at a time; a multiple of 4. */
const PIECE = 1 << 20;

function embeddedText(name: string): string | undefined {
  // Workers have no document.
  const scope = globalThis as { document?: Document };
  return scope.document?.querySelector(`script[data-file="${name}"]`)?.textContent ?? undefined;
}

/** The bytes of a text in base64 without line breaks; an InvalidCharacterError where it is none. */
export function bytesOfBase64(text: string): Uint8Array {
  const padding = text.endsWith("==") ? 2 : text.endsWith("=") ? 1 : 0;
  const bytes = new Uint8Array((text.length / 4) * 3 - padding);
  for (let at = 0; at < text.length; at += PIECE) {
    const piece = atob(text.slice(at, at + PIECE));
    const start = (at / 4) * 3;
    for (let index = 0; index < piece.length; index += 1) {
      bytes[start + index] = piece.charCodeAt(index);
    }
  }
  return bytes;
}

/** A file inside the page. */
export function embeddedFile(name: string): Uint8Array | undefined {
  const text = embeddedText(name);
  return text === undefined ? undefined : bytesOfBase64(text.trim());
}

const TYPES: Readonly<Record<string, string>> = {
  js: "text/javascript",
  wasm: "application/wasm",
  jpg: "image/jpeg",
};
const urls = new Map<string, string>();

/** The address of a file of the player: of one inside the page, or beside the script at `base`. */
export function assetUrl(name: string, base: string): string {
  const known = urls.get(name);
  if (known !== undefined) {
    return known;
  }
  const bytes = embeddedFile(name);
  if (bytes === undefined) {
    return new URL(name, base).href;
  }
  const type = TYPES[name.split(".").pop() ?? ""] ?? "application/octet-stream";
  const url = URL.createObjectURL(new Blob([bytes as Uint8Array<ArrayBuffer>], { type }));
  urls.set(name, url);
  return url;
}

/** A worker of the player. Chromium loads no module of a page without a server, and bundles need none. */
export function startWorker(name: string, base: string): Worker {
  const url = assetUrl(name, base);
  return new Worker(url, { type: url.startsWith("blob:") ? "classic" : "module" });
}
