//! Serves the player (a page with its scripts) and one film to browsers over HTTP/1.1, or writes both as a static site or as
//! one file.
//!
//! A server responds to GET and HEAD for a fixed list of paths, which are compared with known names: no path of a request
//! reaches the file system. The film's metadata is read from the file again for each request, so a file that is replaced gets
//! another entity tag.
//!
//! | path | content |
//! | --- | --- |
//! | `/` | the page: `index.html` of the player |
//! | `/viewer.js` and so on | the other files of the player, in the folder `viewer/dist` when the program was built |
//! | `/film.json` | description of the film: kind, path, name, bytes, and the camera with which it opens |
//! | `/poster.jpg` | a small picture by this camera, or the middle view of a quilt |
//! | `/film.lfold`, `/film.glb` or `/film.png` | the film |

mod answer;
mod conditions;
mod connections;
mod film;
mod film_body;
mod hosts;
mod one_file;
mod opening;
mod player;
mod poster;
mod quilt_shape;
mod range;
mod server;
mod site;
mod watched;

pub use connections::Limits;
pub use film::{Description, Film};
pub use one_file::export_file;
pub use server::{Server, Stop};
pub use site::{Site, export};
