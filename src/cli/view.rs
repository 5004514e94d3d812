//! `lightfold view FILE`: plays a film in the browser, from a local server or as a static site.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::failure::Failure;
use crate::global::EXIT_FAILED;
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::serve::{self, Description, Film, Limits, Server, Site, Stop};
use crate::{ExitStatus, GlobalArgs, damage, refuse};
use codec::decode::{Decoder, StreamInfo};
use codec::error::{Error, Result, counted};
use codec::memory::Budget;
use footage::inspect::{self, Check, FrameRows, InspectSettings};
use simplify::read_glb::check_glb;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold view film.lfold --open\n  lightfold view room.glb --port 8000\n  \
    lightfold view film_qs8x6a0.75.png\n  lightfold view film.lfold --export site\n  lightfold view film.lfold --export film.html\n\n\
    The address of the page is printed on standard output; Ctrl-C stops the server. It serves only the page and FILE, \
    by default only to programs on this machine (see --listen), and only to requests by address or localhost, not by \
    host name. Containers are rendered with WebGPU, which browsers provide to pages from this machine and to HTTPS \
    pages; without WebGPU the page shows small pictures rendered on the CPU. To view from another machine, forward \
    the port (ssh -L 8000:localhost:8000 HOST), or upload the site written by --export to an HTTPS server that \
    supports range requests, such as nginx or Apache; python3 -m http.server does not.\n\n\
    --export writes into a new or empty folder, or replaces an earlier site without other files. All of FILE is \
    checked first: if it is damaged, nothing is written, and the exit code is 1. With a name that ends in .html it \
    writes one file, which browsers open without a server, of a FILE of up to 50 MB.\n\n\
    The server has up to 256 connections. A connection on which the client neither sends a request nor receives 64 \
    KiB of a response within 10 seconds is closed. If all are in use, one is closed for a new client.")]
pub struct Args {
    /// Container (.lfold), simplified scene (.glb) or quilt (.png) to play
    #[arg(value_name = "FILE")]
    pub input: PathBuf,
    /// Port of the server; 0 selects a free port
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in a browser
    #[arg(long)]
    pub open: bool,
    /// Address to listen on, 0.0.0.0 for all interfaces; everyone who reaches it can see the film
    #[arg(long, value_name = "ADDR", default_value_t = Ipv4Addr::LOCALHOST.into(), value_parser = parse_address)]
    pub listen: IpAddr,
    /// Write the page and a copy of FILE instead of starting a server: as a static site in a folder, where an earlier
    /// site is replaced, or as one file, such as film.html
    #[arg(long, value_name = "PATH", conflicts_with_all = ["port", "open", "listen"])]
    pub export: Option<PathBuf>,
    /// Report the address, or the written site, as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    film: &'a Description,
    /// Address of the page.
    #[serde(skip_serializing_if = "Option::is_none")]
    address: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    site: Option<SiteReport<'a>>,
}

#[derive(Serialize)]
struct SiteReport<'a> {
    path: std::borrow::Cow<'a, str>,
    files: u64,
    bytes: u64,
}

/// Parses an IP address, with or without the brackets of IPv6 addresses in URLs.
fn parse_address(text: &str) -> std::result::Result<IpAddr, std::net::AddrParseError> {
    text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(text).parse()
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.input == Path::new("-") {
        return refuse("view cannot read standard input, because the page reads parts of the file: specify a file");
    }
    let open = || {
        let film = Film::open(&args.input)?;
        if film.is_glb() {
            check_glb(&args.input)?;
        }
        Ok(film)
    };
    let Some(folder) = &args.export else { return serve(open()?, args, global) };
    let film = match open() {
        Err(damage @ Error::Invalid { .. }) => return Ok(damaged(&damage, args)),
        opened => opened?,
    };
    if film.is_container()
        && let Some(damage) = find_damage(args, global)?
    {
        return Ok(damaged(&damage, args));
    }
    export(&film, folder, args, global)
}

/// True if a film is exported as one file.
fn is_page(path: &Path) -> bool {
    let is_html = |extension: &std::ffi::OsStr| ["html", "htm"].iter().any(|html| extension.eq_ignore_ascii_case(html));
    path.extension().is_some_and(is_html) && !path.is_dir()
}

/// Reports a film that is not exported because it is damaged, as a failed check.
fn damaged(damage: &Error, args: &Args) -> ExitStatus {
    output::note(format_args!("lightfold: {damage}; nothing was exported"));
    if args.json {
        Failure::new(format!("{damage}; nothing was exported"), EXIT_FAILED, Some(args.input.display().to_string()))
            .print();
    }
    ExitStatus::Failed
}

/// Checks every chunk of a container, and lists the damaged ones.
fn find_damage(args: &Args, global: &GlobalArgs) -> Result<Option<Error>> {
    let decoder = Decoder::open(&args.input)?;
    let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
    let settings = InspectSettings { rows: FrameRows::None, check: Check::ListAll, memory: Budget::default() };
    let progress = Progress::start(global, "checking", inspect::steps(&decoder, &streams))?;
    let inspection = inspect::inspect(&decoder, &streams, settings, &progress)?;
    drop(progress);
    if inspection.damaged.is_empty() {
        return Ok(None);
    }
    output::note(damage::lines(&decoder, &inspection.damaged).trim_end());
    let (found, all) = (inspection.damaged.len(), counted(inspection.totals(None).chunks, "chunk"));
    let message = format!("damaged: {found} of {all}; copy or encode the file again");
    Ok(Some(Error::invalid(message).in_file(&args.input)))
}

fn export(film: &Film, folder: &Path, args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let bytes = std::fs::metadata(&args.input).map_or(0, |metadata| metadata.len());
    let progress = Progress::start(global, "copying", bytes)?;
    let export = if is_page(folder) { serve::export_file } else { serve::export };
    let Site { film, files, bytes } = export(film, folder, &progress)?;
    drop(progress);
    let path = folder.to_string_lossy();
    let report = Report { film: &film, address: None, site: Some(SiteReport { path, files, bytes }) };
    global.report(args.json, &report, || {
        format!("{}: {}, {}", folder.display(), counted(files, "file"), human_bytes(bytes))
    })?;
    Ok(ExitStatus::Passed)
}

/// Serves until Ctrl-C, the normal way to end it.
fn serve(film: Film, args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let stop = Stop::default();
    let at_ctrl_c = stop.clone();
    if let Err(error) = ctrlc::set_handler(move || at_ctrl_c.stop()) {
        return refuse(format!("no handler for Ctrl-C could be set: {error}"));
    }
    let bytes = std::fs::metadata(&args.input).map_or(0, |metadata| metadata.len());
    let description = film.description(bytes, &film.opening());
    let server = Server::bind(film, SocketAddr::new(args.listen, args.port), Limits::default())?;
    let page = server.page();
    if args.json {
        output::print_json(&Report { film: &description, address: Some(&page), site: None })?;
    } else {
        output::print_text(&format!("{page}\n"))?;
    }
    if !args.listen.is_loopback() {
        global.note(format_args!(
            "everyone who reaches {} can see the film; over HTTP from another machine, browsers do not provide \
            WebGPU, and the page shows small pictures of containers",
            server.address()
        ));
    }
    global.note(format_args!("{}: {}; Ctrl-C stops the server", args.input.display(), human_bytes(bytes)));
    if args.open && open::that_detached(&page).is_err() {
        output::note(format_args!("cannot open a browser: open {page} in one"));
    }
    server.run(&stop);
    Ok(ExitStatus::Passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_may_stand_in_brackets() {
        assert_eq!(parse_address("::1"), parse_address("[::1]"));
        assert!(parse_address("127.0.0.1").unwrap().is_loopback());
        for text in ["[::1", "::1]", "localhost", ""] {
            assert!(parse_address(text).is_err(), "{text}");
        }
    }
}
