// Starts the page: reads film.json, which lies beside it, and shows the film that it names.

import { FilmFileError, parseFilmFile } from "./ui/film_file.ts";
import type { FilmFile } from "./ui/film_file.ts";
import { Notice } from "./ui/notices.ts";
import { openShow } from "./ui/opening.ts";
import { Page } from "./ui/page.ts";

/** film.json is short. */
const MAX_CHARACTERS = 65_536;

async function readFilmFile(): Promise<FilmFile> {
  const url = new URL("film.json", document.baseURI);
  const response = await fetch(url, { cache: "no-store" }).catch(() => {
    throw new FilmFileError("film.json, which names the film, cannot be reached.");
  });
  if (!response.ok) {
    throw new FilmFileError(`film.json, which names the film: the server answered ${response.status}.`);
  }
  const json = await response.text();
  if (json.length > MAX_CHARACTERS) {
    throw new FilmFileError("film.json is longer than any that names a film.");
  }
  return parseFilmFile(json, url.href);
}

const reload = (): void => location.reload();

async function start(): Promise<void> {
  try {
    await new Page(await readFilmFile(), openShow).load();
  } catch (error) {
    new Notice(reload, reload).failed(error, undefined);
  }
}

void start();
