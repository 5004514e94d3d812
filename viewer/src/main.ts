// Starts the page: reads film.json, which lies beside it, and shows the film that it names.

import { fetchFilmFile } from "./ui/film_file.ts";
import { Notice } from "./ui/notices.ts";
import { openFilm } from "./ui/opening.ts";
import { Page } from "./ui/page.ts";

async function start(): Promise<void> {
  try {
    const url = new URL("film.json", document.baseURI);
    await new Page(await fetchFilmFile(url.href), openFilm).load();
  } catch (error) {
    new Notice(() => location.reload()).failed(error);
  }
}

void start();
