// Saves the picture of a canvas as a PNG file.

/** Characters that file names have everywhere. */
const UNSAFE = /[^\p{L}\p{N}._-]+/gu;

/** `film_0012.png`: the name without its extension and the frame. */
export function screenshotName(name: string, frame: number): string {
  const stem = name.replace(/\.[a-z0-9]{1,8}$/i, "").replace(UNSAFE, "_");
  return `${stem.replace(/^[._-]+|[._-]+$/g, "").slice(0, 100) || "film"}_${String(frame).padStart(4, "0")}.png`;
}

/** Copies the canvas before it returns (`Player.onShown` says when that can be done); then lets the browser save the copy. */
export async function savePicture(canvas: HTMLCanvasElement, fileName: string): Promise<void> {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  copy.getContext("2d")?.drawImage(canvas, 0, 0);
  const blob = await new Promise<Blob | null>((resolve) => copy.toBlob(resolve, "image/png"));
  if (blob === null) {
    throw new Error("The picture cannot be saved: the browser gives no memory for it.");
  }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = fileName;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
